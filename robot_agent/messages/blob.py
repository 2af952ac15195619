"""Detections of teammates' colour bands in one picture."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Sight = Literal["clear", "dark", "glare", "covered"]
"""Whether a picture is usable: only "clear" ones are evaluated."""


@dataclass(frozen=True, slots=True)
class Blob:
    """One patch of the team's colour in the shape of a band.

    bearing: of its middle from the optical axis, rad, left positive. elevation: rad, up positive.
    width, height: apparent size, rad. range: from the camera to its surface by the apparent height,
    m; range_sigma: m. confidence: 0 to 1, that it is a band at that range.
    """

    bearing: float
    elevation: float
    width: float
    height: float
    range: float
    range_sigma: float
    confidence: float

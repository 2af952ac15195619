"""Detections of teammates' colour bands in one picture."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Sight = Literal["clear", "dark", "glare", "covered"]
"""Whether a picture is usable: only "clear" ones are evaluated."""


@dataclass(frozen=True, slots=True)
class Blob:
    """One patch of the team's colour in the shape of a band.

    bearing: rad from the optical axis to its middle, left positive. elevation: rad, up positive.
    width, height: rad it fills. range: m from the camera to its surface, by its apparent height;
    range_sigma: m. confidence: 0 to 1, how well colour, shape and place fit a band at that range.
    """

    bearing: float
    elevation: float
    width: float
    height: float
    range: float
    range_sigma: float
    confidence: float

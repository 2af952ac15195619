"""Idleness of a settled patrol: over the second half of a run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from maps.border import Border
from tools.metrics.idleness import border_visits, idleness_figures


def settled_figures(
    border: Border,
    positions: Sequence[NDArray[np.float64]],
    t: NDArray[np.float64],
    wrecks: Sequence[tuple[float, float]] = (),
) -> dict[str, Any]:
    """Return from_s, half of the run, and the figures of idleness from then on.

    positions: each robot's true (n, 2), m, at times t (n,). The first half contains the transient
    until the robots have spread over the border.
    """
    half = t.size // 2
    visits = border_visits(border, [place[half:] for place in positions], t[half:], wrecks)
    return {"from_s": float(t[half]), **idleness_figures(visits)}

"""Idleness of a patrol that has settled: over the second half of a run."""

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
    """Return from_s and the figures of idleness from then on: half of the run is start.

    positions: each robot's true (n, 2), m, at times t (n,), s. Robots that learn where the others
    are need a while; the figures over all of the run contain it.
    """
    half = t.size // 2
    visits = border_visits(border, [place[half:] for place in positions], t[half:], wrecks)
    return {"from_s": float(t[half]), **idleness_figures(visits)}

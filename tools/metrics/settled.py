"""The figures of a border's visits, and the same of a settled patrol: over a run's second half."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from maps.border import Border
from tools.metrics.border_visits import BorderVisits, border_visits
from tools.metrics.idleness import idleness_figures
from tools.metrics.intruder_exposure import intruder_figures
from tools.metrics.unpredictability import unpredictability_figures


def visit_figures(visits: BorderVisits | None) -> dict[str, Any]:
    """Return idleness, unpredictability and probabilities of detection; None without visits."""
    return {
        **idleness_figures(visits),
        **unpredictability_figures(visits),
        **intruder_figures(visits),
    }


def settled_figures(
    border: Border,
    positions: Sequence[NDArray[np.float64]],
    t: NDArray[np.float64],
    wrecks: Sequence[tuple[float, float]] = (),
) -> dict[str, Any]:
    """Return from_s, half of the run, and the figures of the visits from then on.

    positions: each robot's true (n, 2), m, at times t (n,). The first half contains the transient
    until the robots have spread over the border.
    """
    half = t.size // 2
    visits = border_visits(border, [place[half:] for place in positions], t[half:], wrecks)
    return {"from_s": float(t[half]), **visit_figures(visits)}

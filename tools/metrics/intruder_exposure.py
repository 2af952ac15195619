"""Probability that an intruder who waits at the border is seen, at the weakest place and at any.

The weakest place is the point of the border with the longest gap between visits. The intruder
arrives at a uniformly random time of the run and is seen if a robot visits the place within the
dwell time.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tools.metrics.idleness import BorderVisits

DWELL_S = (15.0, 30.0, 60.0, 120.0)


def intruder_figures(visits: BorderVisits | None) -> dict[str, Any]:
    """Return the probabilities by dwell time, at the weakest place and at any.

    None without visits, and for a dwell time longer than the run.
    """
    if visits is None or not visits.gaps:
        return {"intruder_seen": None}
    weakest = int(np.argmax([gaps.max(initial=0.0) for gaps in visits.gaps]))
    waits = _times_to_visit(visits.t, visits.visited)
    return {
        "intruder_seen": {
            "dwell_s": list(DWELL_S),
            "weakest_place_m": float(visits.abscissae[weakest]),
            "weakest_place": [_seen(visits.t, waits[:, [weakest]], dwell) for dwell in DWELL_S],
            "any_place": [_seen(visits.t, waits, dwell) for dwell in DWELL_S],
        }
    }


def _times_to_visit(t: NDArray[np.float64], visited: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Return (n, points) times, s, from each sample to a point's next visit; inf if none."""
    times = np.where(visited, t[:, None], np.inf)
    next_visit: NDArray[np.float64] = np.minimum.accumulate(times[::-1], axis=0)[::-1]
    return next_visit - t[:, None]


def _seen(t: NDArray[np.float64], waits: NDArray[np.float64], dwell: float) -> float | None:
    whole = t <= t[-1] - dwell
    return float((waits[whole] <= dwell).mean()) if whole.any() else None

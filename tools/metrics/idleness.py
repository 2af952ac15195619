"""Idleness of the border's points, with the definitions of patrolling_sim.

A point is visited while a robot is within ``VISIT_RADIUS`` of it; the time between two visits, or
between a visit and an end of the run, is a gap. The instantaneous idleness of a point is the time
since its last visit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from maps.border import Border

VISIT_RADIUS = 0.25
BORDER_STEP = 0.25
BESIDE_WRECK = 2.0
"""Length of border on each side of a wreck that cannot be driven, m: teammates turn before it."""
ENTROPY_BIN_S = 10.0
"""Bin width of the entropy of return times, s."""


@dataclass(frozen=True, eq=False)
class BorderVisits:
    """When the border's points were visited.

    t: (n,) s, evenly spaced. abscissae: (points,) m. visited: (n, points), whether a robot was
    within the radius. gaps: for each point, its gaps in s, in order; whole: for each point, the
    gaps between two visits. visits: number for each point.
    """

    t: NDArray[np.float64]
    abscissae: NDArray[np.float64]
    visited: NDArray[np.bool_]
    gaps: list[NDArray[np.float64]]
    whole: list[NDArray[np.float64]]
    visits: list[int]


def border_visits(
    border: Border,
    positions: Sequence[NDArray[np.float64]],
    t: NDArray[np.float64],
    wrecks: Sequence[tuple[float, float]] = (),
) -> BorderVisits:
    """Return all visits of robots at true positions, each (n, 2) m in the map, at times t (n,).

    The border beside wrecks, at (x, y) m, is left out, and so are the end points of an open one:
    a robot's front reaches them, but its centre turns half a robot length before.
    """
    points = border.polyline(BORDER_STEP)
    if not border.closed:
        points = points[1:-1]
    for wreck in wrecks:
        points = points[np.hypot(*(points - wreck).T) > BESIDE_WRECK]
    visited = np.zeros((t.size, len(points)), dtype=bool)
    for position in positions:
        dx, dy = (position[:, axis, None] - points[:, axis] for axis in (0, 1))
        visited |= dx * dx + dy * dy <= VISIT_RADIUS**2
    step = float(np.median(np.diff(t))) if t.size > 1 else 0.0
    gaps, whole, visits = [], [], []
    for column in visited.T:
        seen = t[column]
        between = np.diff(seen)
        whole.append(between[between > 1.5 * step])
        ends = np.diff(np.concatenate((t[:1], seen, t[-1:])))
        gaps.append(ends[ends > 1.5 * step])
        visits.append(len(whole[-1]) + 1 if seen.size else 0)
    return BorderVisits(t, border.project_many(points)[0], visited, gaps, whole, visits)


def idleness_figures(visits: BorderVisits | None) -> dict[str, Any]:
    """Return the figures of ``bench --json``; all None where no robot reached the border.

    idleness_s: average (over the points, of their mean gap), worst_average (the largest of these
    means), worst (the largest gap), mean and deviation of all gaps, instantaneous (over points
    and time). visits: of the least visited point (complete cycles), mean and most. return_entropy_
    bit: entropy of the times between visits in bins of 10 s; 0 for a periodic patrol.
    """
    if visits is None:
        return {
            "idleness_s": dict.fromkeys(
                ("average", "worst_average", "worst", "mean", "deviation", "instantaneous")
            ),
            "visits": dict.fromkeys(("cycles", "mean", "most")),
            "return_entropy_bit": None,
        }
    means = [float(gaps.mean()) if gaps.size else 0.0 for gaps in visits.gaps]
    gaps = np.concatenate(visits.gaps)
    duration = float(visits.t[-1] - visits.t[0])
    waited = float((gaps**2).sum()) / 2.0  # a gap g adds the integral of 0..g
    return {
        "idleness_s": {
            "average": float(np.mean(means)),
            "worst_average": max(means),
            "worst": float(gaps.max(initial=0.0)),
            "mean": float(gaps.mean()) if gaps.size else 0.0,
            "deviation": float(gaps.std()) if gaps.size else 0.0,
            "instantaneous": waited / (duration * len(means)) if duration else 0.0,
        },
        "visits": {
            "cycles": min(visits.visits),
            "mean": float(np.mean(visits.visits)),
            "most": max(visits.visits),
        },
        "return_entropy_bit": return_entropy(np.concatenate(visits.whole)),
    }


def return_entropy(times: NDArray[np.float64]) -> float | None:
    """Return the entropy, bit, of return times (n,), s (Duan, George and Bullo); None if empty."""
    if not times.size:
        return None
    counts = np.unique(np.floor(times / ENTROPY_BIN_S), return_counts=True)[1]
    share = counts / times.size
    return abs(float(-(share * np.log2(share)).sum()))

"""Idleness of the border's places, with the definitions of patrolling_sim (Portugal and Rocha).

An interval is the time from one visit of a place to the next, each counted as a robot that drives
past makes it. What the begin and the end of the record cut off is no interval, but a place has not
been visited for at least so long. The instantaneous idleness of a place is the time since its last
visit.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tools.metrics.border_visits import BorderVisits, PlaceVisits


def intervals_of(place: PlaceVisits, passing: float) -> NDArray[np.float64]:
    """Return the times (k - 1,), s, from visit to visit; passing: s that each visit takes."""
    return place.gaps + passing


def longest_of(place: PlaceVisits, passing: float) -> float:
    """Return the longest time from visit to visit, or before the first or after the last, s."""
    return max(*place.cut, float(intervals_of(place, passing).max(initial=0.0)))


def mean_of(place: PlaceVisits, passing: float) -> float:
    """Return the mean time from visit to visit, s; of a place with none, what was cut off."""
    intervals = intervals_of(place, passing)
    return float(intervals.mean()) if intervals.size else max(place.cut)


def idleness_figures(visits: BorderVisits | None) -> dict[str, Any]:
    """Return the figures of ``bench --json``; all None where no robot reached the border.

    idleness_s: average (over the places, of their mean interval), worst_average (the largest of
    these means), worst (the longest time without a visit, cut off or not), mean and deviation of
    all intervals, instantaneous (over places and time). visits: of the least visited place
    (complete cycles), mean and most.
    """
    if visits is None or not visits.places:
        return {
            "idleness_s": dict.fromkeys(
                ("average", "worst_average", "worst", "mean", "deviation", "instantaneous")
            ),
            "visits": dict.fromkeys(("cycles", "mean", "most")),
        }
    passing = visits.passing
    means = [mean_of(place, passing) for place in visits.places]
    intervals = np.concatenate([intervals_of(place, passing) for place in visits.places])
    counts = [len(place.arrivals) for place in visits.places]
    return {
        "idleness_s": {
            "average": float(np.mean(means)),
            "worst_average": max(means),
            "worst": max(longest_of(place, passing) for place in visits.places),
            "mean": float(intervals.mean()) if intervals.size else float(np.mean(means)),
            "deviation": float(intervals.std()) if intervals.size else 0.0,
            "instantaneous": _instantaneous(visits),
        },
        "visits": {"cycles": min(counts), "mean": float(np.mean(counts)), "most": max(counts)},
    }


def _instantaneous(visits: BorderVisits) -> float:
    """Return the mean over places and time of the time since the last visit, s."""
    duration = float(visits.t[-1] - visits.t[0])
    if not duration:
        return 0.0
    waited = 0.0
    for place in visits.places:
        cut = place.cut if len(place.arrivals) else place.cut[:1]
        gaps = np.concatenate((place.gaps, cut))
        waited += float((gaps**2).sum()) / 2.0  # a gap g adds the integral of 0..g
    return waited / (duration * len(visits.places))

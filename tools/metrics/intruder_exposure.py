"""Probability that an intruder who stays at the border is seen, at the place best for the intruder.

An intruder needs a dwell time at one place and is seen if a robot visits it meanwhile. One strikes
at a random moment. One watches the place, sees the last robot leave and strikes at the best time
after it (the adversary of a stationary place in Agmon, Kaminka and Kraus, "Multi-robot adversarial
patrolling", 2011, with less knowledge). What no patrol can exceed is in ``detection_bounds.py``.
"""

from __future__ import annotations

from collections import defaultdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tools.metrics.border_visits import BorderVisits
from tools.metrics.unpredictability import stretches

DWELL_S = (20.0, 40.0, 60.0, 90.0)
_RAREST = 0.05
"""Share of the gaps that must last until the watcher's moment: waiting for one that comes in fewer
than one of twenty visits is not counted, nor could a run of some hours measure it. Ours."""
_FEWEST = 20  # gaps that last so long
_FOLDS = 4
_STEP = 1.0  # s between two moments that are tried


def intruder_figures(visits: BorderVisits | None) -> dict[str, Any]:
    """Return ``intruder_seen`` of ``bench --json``: by intruder, by dwell time, at the worst place.

    random: least over the places, of a random moment; watcher: least over the moments after a
    visit and the ways the robot left, of all places of a closed border together and of each tenth
    of an open one. None where the run is too short to tell.
    """
    if visits is None or not visits.places:
        return {"intruder_seen": None}
    waits = _times_to_visit(visits.t, visits.visited)
    gaps = _gaps_by_way(visits)
    return {
        "intruder_seen": {
            "random": {f"{dwell:g}": _at_random(visits.t, waits, dwell) for dwell in DWELL_S},
            "watcher": {
                f"{dwell:g}": min(
                    (s for each in gaps if (s := _after_a_visit(each, dwell)) is not None),
                    default=None,
                )
                for dwell in DWELL_S
            },
        }
    }


def least_detection(first_visits: NDArray[np.float64], dwell: float) -> float:
    """Return the probability that one who sees everything is seen, at the place best for him now.

    first_visits: (rollouts, places) s from now until the place's next visit in each of some equally
    likely futures; inf if there is none. The least over the places of the share of futures would be
    too low, as chance is among what it chooses by: so the place is chosen by three quarters of the
    futures and its probability taken from the rest, for each quarter in turn.
    """
    seen = first_visits <= dwell
    quarters = [slice(number, None, _FOLDS) for number in range(min(_FOLDS, len(seen)))]
    shares = []
    for quarter in quarters:
        others = np.ones(len(seen), dtype=bool)
        others[quarter] = len(seen) < _FOLDS
        place = int(seen[others].mean(axis=0).argmin())
        shares.append(float(seen[quarter, place].mean()))
    return float(np.mean(shares))


def _times_to_visit(t: NDArray[np.float64], visited: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Return (n, places) times, s, from each sample to a place's next visit; inf if none."""
    times = np.where(visited, t[:, None], np.inf)
    next_visit: NDArray[np.float64] = np.minimum.accumulate(times[::-1], axis=0)[::-1]
    return next_visit - t[:, None]


def _at_random(t: NDArray[np.float64], waits: NDArray[np.float64], dwell: float) -> float | None:
    """Return the least share of moments, over the places, with a visit within the dwell time."""
    whole = t <= t[-1] - dwell
    return float((waits[whole] <= dwell).mean(axis=0).min()) if whole.any() else None


def _gaps_by_way(visits: BorderVisits) -> list[NDArray[np.float64]]:
    """Return the sorted gaps, s, of each stretch and way in which the robot before them left."""
    found: defaultdict[tuple[int, int], list[float]] = defaultdict(list)
    for stretch, place in zip(stretches(visits), visits.places, strict=True):
        for way, gap in zip(place.ways.tolist(), place.gaps.tolist(), strict=False):
            found[stretch, way].append(gap)
    return [np.sort(gaps) for way, gaps in sorted(found.items())]


def _after_a_visit(gaps: NDArray[np.float64], dwell: float) -> float | None:
    """Return the least probability, over the moments, that a gap ends within the dwell time.

    gaps: (k,) s, sorted. None where too few reach any moment.
    """
    count = len(gaps)
    if count < _FEWEST:
        return None
    needed = max(_FEWEST, _RAREST * count)
    moments = np.arange(0.0, gaps[-1], _STEP)
    lasting = count - np.searchsorted(gaps, moments, side="right")
    ended = np.searchsorted(gaps, moments + dwell, side="right") - (count - lasting)
    often = lasting >= needed
    return float((ended[often] / lasting[often]).min()) if often.any() else None

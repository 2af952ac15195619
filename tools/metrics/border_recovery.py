"""Recovery of the patrol after robots have stopped permanently on the border.

Wrecks divide the border into stretches. The remaining robots drive their own stretch; a stretch
between two wrecks without a robot stays undriven, since no robot passes a wreck.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from maps.border import Border
from robot_agent.patrol.closing_in import CLOSEST
from tools.metrics.border_visits import BESIDE_WRECK, BORDER_STEP, VISIT_RADIUS, BorderVisits
from tools.metrics.wreck import Wreck

_TO_SHIFT = CLOSEST - 2.0 * VISIT_RADIUS
"""Free length, m, that robots need to visit the points between two of them."""


def recovery_figures(
    border: Border,
    places: Sequence[NDArray[np.float64]],
    visits: BorderVisits | None,
    wrecks: Sequence[Wreck],
    speed: float,
) -> dict[str, Any]:
    """Return the wrecks with the stretch beside each, and the time until the rest was driven again.

    places: positions (n, 2), m, of each remaining robot, at the times of visits. driven_again_s:
    from the last wreck until every point on a stretch with robots was visited, None if one was not;
    laps: the same in laps round (or along) the border at the patrol's speed, m/s; abandoned_m:
    length between wrecks without a robot; crowded_m: undriven length of stretches that have no
    room for their robots to drive all of it.
    """
    if not wrecks:
        return {"wrecks": []}
    figures: dict[str, Any] = {"wrecks": [_wreck_figures(border, wreck) for wreck in wrecks]}
    if visits is None or not visits.visited.size:
        return {**figures, "after_wrecks": None}
    start = int(np.searchsorted(visits.t, max(wreck.since for wreck in wrecks)))
    start = min(start, len(visits.t) - 1)
    cuts = np.sort(border.project_many([wreck[:2] for wreck in wrecks])[0])
    here = np.array([place[start] for place in places]).reshape(-1, 2)
    robots = np.bincount(
        _stretch(border, cuts, border.project_many(here)[0]), minlength=len(cuts) + 1
    )
    stretch = _stretch(border, cuts, visits.abscissae)
    left_for = robots[stretch] > 0
    crowded = (_free_length(border, cuts, robots) < _TO_SHIFT)[stretch]
    after = visits.visited[start:]
    seen = np.asarray(after.any(axis=0))
    first = visits.t[start:][after.argmax(axis=0)] - visits.t[start]
    again = float(first[left_for].max()) if left_for.any() and seen[left_for].all() else None
    lap = border.length / speed
    return {
        **figures,
        "after_wrecks": {
            "since_s": float(visits.t[start]),
            "driven_again_s": again,
            "laps": None if again is None else again / lap,
            "undriven_m": float(np.count_nonzero(left_for & ~seen)) * BORDER_STEP,
            "abandoned_m": float(np.count_nonzero(~left_for)) * BORDER_STEP,
            "crowded_m": float(np.count_nonzero(left_for & ~seen & crowded)) * BORDER_STEP,
        },
    }


def _free_length(
    border: Border, cuts: NDArray[np.float64], robots: NDArray[np.intp]
) -> NDArray[np.float64]:
    """Return each stretch's length, m, less the space its robots and wrecks need at minimum.

    cuts: (w,) abscissae, m, ascending. robots: (w + 1,) counts; on a closed border the last is 0.
    """
    gaps = robots + 1
    if border.closed:
        lengths = np.append(np.diff(cuts, prepend=cuts[-1] - border.length), 0.0)
    else:
        lengths = np.diff(cuts, prepend=0.0, append=border.length)
        gaps[[0, -1]] -= 1  # no wreck at the ends of the border
    return np.asarray(lengths - gaps * CLOSEST)


def _wreck_figures(border: Border, wreck: Wreck) -> dict[str, Any]:
    """Return a wreck's figures with the stretch left out of the idleness (wrapped if closed)."""
    s = border.project(wreck.x, wreck.y).abscissa
    ends = (s - BESIDE_WRECK, s + BESIDE_WRECK)
    if border.closed:
        stretch = [end % border.length for end in ends]
    else:
        stretch = [min(max(end, 0.0), border.length) for end in ends]
    return {
        "robot": wreck.robot,
        "since_s": wreck.since,
        "abscissa_m": s,
        "stretch_m": stretch,
        "distance_from_border_m": border.project(wreck.x, wreck.y).distance,
    }


def _stretch(
    border: Border, cuts: NDArray[np.float64], abscissae: NDArray[np.float64]
) -> NDArray[np.intp]:
    """Return the index of the stretch between cuts (ascending) of each abscissa."""
    number = np.searchsorted(cuts, abscissae)
    return number % len(cuts) if border.closed else number

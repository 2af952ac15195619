"""Finds the offset of a robot's clock by mutual sightings, however wrong the clock is.

A teammate seen at a place must have been there by its own poses. Every offset at which the
recordings overlap is tried, on a grid: their number depends on how long the recordings are, not on
how far apart their clocks. The one that explains most sightings counts if no other explains nearly
as many; one close to the wall clock is preferred.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import permutations

import numpy as np

from tools.report.run_log import Floats, RunLog

CLOCK_S = 120.0
"""Difference of wall clocks that is to be expected; within it an offset needs no clear lead."""
COARSE_S = 0.5
FINE_S = 0.02
SEEN_M = 1.0
"""Distances of a sighting from the teammate's own pose are clipped to this: beyond, it is of
another robot or another time."""
NEEDED = 30
"""Fewest sightings of a pair, at ten a second, to estimate its clock offset from."""
MOVED_M = 0.4
"""Least extent of a teammate's seen path: a standing one does not show the clock offset."""
STEP_M = 0.1
"""Way of the seen teammate between two sightings that count: one that stands in view fits many
offsets, and would outvote the others."""
MOST = 1000
"""Sightings of a pair that are compared, evenly chosen."""
APART_S = 5.0
"""Offsets this far from the best one are others."""
LEAST = 10.0
"""Least support of a correction: a metre of a teammate's path, seen where it was. Ours."""
RIVAL = 0.75
"""Share of the best offset's support from which another one makes the choice doubtful: ours."""


@dataclass(frozen=True, slots=True)
class ClockFit:
    """Correction of a run's clock that sightings tell, s; None: none, with the trouble in words."""

    correction: float | None
    residual: float | None = None
    """Median distance of sightings from the teammate's own poses, m."""
    support: float = 0.0
    """Number of sightings explained."""
    trouble: str = ""


def best_correction(run: RunLog, others: Sequence[RunLog]) -> ClockFit:
    """Return the correction of a run's shift that fits the sightings best.

    others: runs of other robots on the team's clock. Sightings of the run by them count as well as
    its own of them.
    """
    pairs = [
        pair
        for other in others
        for observer, seen in permutations((run, other))
        if (pair := _Sightings.of(observer, seen, sign=1.0 if observer is run else -1.0))
        is not None
    ]
    if not pairs:
        return ClockFit(None, trouble="too few mutual sightings to correct it")
    lowest = min(other.shift - run.shift - run.end for other in others)
    highest = max(other.shift + other.end - run.shift for other in others)
    corrections = np.arange(lowest, highest + COARSE_S, COARSE_S, dtype=np.float64)
    support = np.sum([pair.support(corrections) for pair in pairs], axis=0)
    chosen = _clear_best(corrections, support)
    if chosen is None:
        return ClockFit(None, trouble="its sightings fit several offsets alike")
    if support[chosen] < LEAST:
        return ClockFit(None, trouble="too few mutual sightings to correct it")
    correction, residual = _refined(float(corrections[chosen]), pairs)
    return ClockFit(correction, residual, float(support[chosen]))


def _clear_best(corrections: Floats, support: Floats) -> int | None:
    """Return the index of the correction with most support, None if another has nearly as much.

    corrections, support: (n,).
    """
    best = int(np.argmax(support))
    near = np.abs(corrections) <= CLOCK_S
    if near.any():
        expected = int(np.argmax(np.where(near, support, -1.0)))
        if support[expected] >= RIVAL * support[best]:
            return expected
    apart = np.abs(corrections - corrections[best]) > APART_S
    if support[apart].max(initial=0.0) >= RIVAL * support[best]:
        return None
    return best


def _refined(middle: float, pairs: Sequence[_Sightings]) -> tuple[float, float]:
    """Return the best correction near one on the grid, and its residual (``ClockFit``)."""

    def misses(correction: float) -> Floats:
        return np.concatenate([pair.misses(correction) for pair in pairs])

    fine = np.arange(middle - 2 * COARSE_S, middle + 2 * COARSE_S, FINE_S).tolist()
    best = float(fine[int(np.argmin([misses(correction).mean() for correction in fine]))])
    found = misses(best)
    return best, float(np.median(found[found < SEEN_M]))


@dataclass(frozen=True, eq=False)
class _Sightings:
    """Positions of a teammate as one robot saw it, and the teammate's own track."""

    t: Floats
    """Team time by the observer's clock, (n,), s."""
    position: Floats
    track_t: Floats
    """Team time by the teammate's clock, (m,), s."""
    track: Floats
    chosen: list[int]
    """Indices of the sightings that tell an offset."""
    sign: float
    """+1: the correction shifts the observer's clock; -1: the teammate's."""

    @classmethod
    def of(cls, observer: RunLog, seen: RunLog, sign: float) -> _Sightings | None:
        """Return the sightings of a pair; None if too few, or the teammate hardly moved."""
        there = np.isfinite(observer.neighbor[:, 0])
        if there.sum() < NEEDED or seen.decision_t.size < NEEDED:
            return None
        position = observer.neighbor[there]
        if np.ptp(position, axis=0).max() < MOVED_M:
            return None
        return cls(
            observer.decision_t[there] + observer.shift,
            position,
            seen.decision_t + seen.shift,
            seen.pose[:, :2],
            _moving(position),
            sign,
        )

    def support(self, corrections: Floats) -> Floats:
        """Return how well each correction, (n,), COARSE_S apart, explains the sightings, (n,).

        A sighting gives 1 where the teammate was at the very place, falling to 0 at SEEN_M.
        """
        grid_t = np.arange(self.track_t[0], self.track_t[-1], COARSE_S)
        x, y = (np.interp(grid_t, self.track_t, self.track[:, axis]) for axis in (0, 1))
        # The place of the first correction on the grid, in whole steps, for each sighting:
        offset = corrections[0] if self.sign > 0 else -corrections[-1]
        first = np.rint((self.t[self.chosen] + offset - grid_t[0]) / COARSE_S).astype(np.int64)
        found = np.zeros(corrections.size)
        for index, (at_x, at_y) in zip(first, self.position[self.chosen], strict=True):
            low, high = max(index, 0), min(index + corrections.size, grid_t.size)
            if low < high:
                away = np.hypot(x[low:high] - at_x, y[low:high] - at_y)
                found[low - index : high - index] += np.maximum(1.0 - away / SEEN_M, 0.0)
        return found if self.sign > 0 else found[::-1]

    def misses(self, correction: float) -> Floats:
        """Return each sighting's distance from the teammate's track, (n,), m, at most SEEN_M."""
        t = self.t + self.sign * correction
        x, y = (np.interp(t, self.track_t, self.track[:, axis]) for axis in (0, 1))
        misses = np.hypot(x - self.position[:, 0], y - self.position[:, 1])
        misses[(t < self.track_t[0]) | (t > self.track_t[-1])] = SEEN_M
        return np.asarray(np.minimum(misses, SEEN_M))


def _moving(position: Floats) -> list[int]:
    """Return indices of positions, (n, 2), STEP_M from the one before, MOST at most."""
    chosen = [0]
    for index, place in enumerate(position):
        if np.hypot(*(place - position[chosen[-1]])) >= STEP_M:
            chosen.append(index)
    return chosen[:: -(-len(chosen) // MOST)]

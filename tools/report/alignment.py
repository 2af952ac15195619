"""Aligns a team's recordings to one clock: stated, shared, or estimated from mutual sightings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import permutations

import numpy as np

from tools.report.run_log import Floats, RunLog

SEARCH_S = 120.0
"""Largest difference of two robots' wall clocks."""
COARSE_S = 0.5
FINE_S = 0.02
SEEN_M = 1.0
"""Distances of a sighting from the teammate's own pose are clipped to this: beyond, it is of
another robot or another time."""
NEEDED = 30
"""Fewest sightings of a pair, at ten a second, to estimate its clock offset from."""
MOVED_M = 0.4
"""Least extent of a teammate's seen path: a standing one does not show the clock offset."""


class AlignmentError(ValueError):
    """Recordings cannot be put on one clock; the message names option and remedy."""


@dataclass(frozen=True, slots=True)
class ClockNote:
    """Correction added to one robot's wall clock, s, and its source."""

    robot: str
    correction: float
    how: str
    residual: float | None = None
    """Median distance of sightings from the teammate's own poses, m; None: not by sightings."""


def align(
    runs: Sequence[RunLog],
    stated: Mapping[str, float] | None = None,
    *,
    trust_host: bool = True,
) -> list[ClockNote]:
    """Set each run's ``shift``, so that all share one clock that starts at the first recording.

    stated: corrections by robot, s, which are used unchecked. trust_host: runs recorded on one host
    use its monotonic clock. Other wall clocks are corrected to fit sightings to the teammates' own
    poses. Returns one note per run. Raises AlignmentError for a stated robot without a recording.
    """
    stated = stated or {}
    for robot in stated:
        if robot not in {run.name for run in runs}:
            raise AlignmentError(
                f"--offset {robot}: no recording of it; robots are "
                f"{', '.join(sorted({run.name for run in runs}))}"
            )
    origin = min(run.header.start_wall_ns for run in runs)
    for run in runs:
        run.shift = (run.header.start_wall_ns - origin) / 1e9
    notes = [
        _set_clock(run, runs[0], runs[:number], stated, trust_host=trust_host)
        for number, run in enumerate(runs)
    ]
    first = min(run.shift for run in runs)
    for run in runs:
        run.shift -= first
    return notes


def _set_clock(
    run: RunLog,
    first: RunLog,
    settled: Sequence[RunLog],
    stated: Mapping[str, float],
    *,
    trust_host: bool,
) -> ClockNote:
    """Correct one run's shift by the runs before it; return how."""
    before = run.shift
    if run.name in stated:
        run.shift += stated[run.name]
        return ClockNote(run.name, stated[run.name], "stated")
    if run is first:
        return ClockNote(run.name, 0.0, "its clock is the team's")
    if trust_host and run.header.boot and run.header.boot == first.header.boot:
        apart = (run.header.start_monotonic_ns - first.header.start_monotonic_ns) / 1e9
        run.shift = first.shift + apart
        return ClockNote(run.name, run.shift - before, "same host, same monotonic clock")
    if trust_host and run.header.source == first.header.source == "bench":
        return ClockNote(run.name, 0.0, "same bench, same virtual clock")
    others = [other for other in settled if other.name != run.name]
    found = best_correction(run, others)
    if found is None:
        return ClockNote(run.name, 0.0, "wall clock: too few mutual sightings to correct it")
    correction, residual = found
    run.shift += correction
    return ClockNote(run.name, correction, "mutual sightings", residual)


def best_correction(run: RunLog, others: Sequence[RunLog]) -> tuple[float, float] | None:
    """Return the correction of a run's shift, s, that fits the sightings best, and the residual, m.

    Sightings of the run by the others count as well as its own of them. None if there are too few.
    """
    pairs = [
        pair
        for other in others
        for observer, seen in permutations((run, other))
        if (pair := _Sightings.of(observer, seen, sign=1.0 if observer is run else -1.0))
        is not None
    ]
    if not pairs:
        return None

    def cost(correction: float) -> float:
        return float(np.concatenate([pair.misses(correction) for pair in pairs]).mean())

    coarse = np.arange(-SEARCH_S, SEARCH_S + COARSE_S, COARSE_S)
    middle = coarse[int(np.argmin([cost(c) for c in coarse.tolist()]))]
    fine = np.arange(middle - 2 * COARSE_S, middle + 2 * COARSE_S, FINE_S)
    best = float(fine[int(np.argmin([cost(c) for c in fine]))])
    misses = np.concatenate([pair.misses(best) for pair in pairs])
    near = misses[misses < SEEN_M]
    if near.size < NEEDED:
        return None
    return best, float(np.median(near))


@dataclass(frozen=True, eq=False)
class _Sightings:
    """Positions of a teammate as one robot saw it, and the teammate's own track."""

    t: Floats
    """Team time by the observer's clock, (n,), s."""
    position: Floats
    track_t: Floats
    """Team time by the teammate's clock, (m,), s."""
    track: Floats
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
            sign,
        )

    def misses(self, correction: float) -> Floats:
        """Return each sighting's distance from the teammate's track, (n,), m, at most SEEN_M."""
        t = self.t + self.sign * correction
        x, y = (np.interp(t, self.track_t, self.track[:, axis]) for axis in (0, 1))
        misses = np.hypot(x - self.position[:, 0], y - self.position[:, 1])
        misses[(t < self.track_t[0]) | (t > self.track_t[-1])] = SEEN_M
        return np.asarray(np.minimum(misses, SEEN_M))

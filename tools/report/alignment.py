"""One clock for a team's recordings: told, shared, or found where robots saw each other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import permutations

import numpy as np

from tools.report.run_log import Floats, RunLog

SEARCH_S = 120.0
"""Wall clocks of two robots are not further apart than this."""
COARSE_S = 0.5
FINE_S = 0.02
SEEN_M = 1.0
"""A sighting further than this from the teammate's own pose counts as this far: it is of another
robot, or of another time."""
NEEDED = 30
"""Sightings of a pair, at ten a second, that say something about its clocks."""
MOVED_M = 0.4
"""Nothing is learned from a teammate that moved less than this while it was seen."""


class AlignmentError(ValueError):
    """Recordings that cannot be put on one clock; the message names option and remedy."""


@dataclass(frozen=True, slots=True)
class ClockNote:
    """How one robot's clock was set: what was added to its wall clock, s, and why."""

    robot: str
    correction: float
    how: str
    residual: float | None = None
    """Median distance of sightings from where the teammate says it was, m."""


def align(
    runs: Sequence[RunLog],
    stated: Mapping[str, float] | None = None,
    *,
    trust_host: bool = True,
) -> list[ClockNote]:
    """Set each run's ``shift``, so that all share one clock that starts with the first of them.

    A correction that is stated (robot -> s) is taken. Runs recorded on one host share its
    monotonic clock, unless told otherwise. Else the wall clocks are corrected by what makes
    sightings fit the teammates' own poses. Raises AlignmentError for a robot that is not there.
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
    """Correct one run's shift by those before it."""
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
    """Return the correction of a run's shift, s, that makes sightings fit, and their residual, m.

    Sightings of the run by the others count as well as its own of them; None where there are too
    few that would tell.
    """
    pairs = [
        pair
        for other in others
        for seer, seen in permutations((run, other))
        if (pair := _Sightings.of(seer, seen, sign=1.0 if seer is run else -1.0)) is not None
    ]
    if not pairs:
        return None

    def cost(correction: float) -> float:
        return float(np.concatenate([pair.misses(correction) for pair in pairs]).mean())

    coarse = np.arange(-SEARCH_S, SEARCH_S + COARSE_S, COARSE_S)
    middle = coarse[int(np.argmin([cost(c) for c in coarse]))]
    fine = np.arange(middle - 2 * COARSE_S, middle + 2 * COARSE_S, FINE_S)
    best = float(fine[int(np.argmin([cost(c) for c in fine]))])
    misses = np.concatenate([pair.misses(best) for pair in pairs])
    near = misses[misses < SEEN_M]
    if near.size < NEEDED:
        return None
    return best, float(np.median(near))


@dataclass(frozen=True, eq=False)
class _Sightings:
    """Where one robot saw a teammate, beside where another says it was."""

    t: Floats
    """Team time by the seer's clock, s."""
    place: Floats
    track_t: Floats
    """Team time by the seen one's clock, s."""
    track: Floats
    sign: float
    """+1 where correcting the run moves the seer's clock, -1 where it moves the seen one's."""

    @classmethod
    def of(cls, seer: RunLog, seen: RunLog, sign: float) -> _Sightings | None:
        """Return the sightings of a pair, None where they would tell nothing."""
        there = np.isfinite(seer.neighbor[:, 0])
        if there.sum() < NEEDED or seen.decision_t.size < NEEDED:
            return None
        place = seer.neighbor[there]
        if np.ptp(place, axis=0).max() < MOVED_M:
            return None
        return cls(
            seer.decision_t[there] + seer.shift,
            place,
            seen.decision_t + seen.shift,
            seen.pose[:, :2],
            sign,
        )

    def misses(self, correction: float) -> Floats:
        """Return (n,) how far each sighting is from the seen one's track, m, at most SEEN_M."""
        t = self.t + self.sign * correction
        x, y = (np.interp(t, self.track_t, self.track[:, axis]) for axis in (0, 1))
        misses = np.hypot(x - self.place[:, 0], y - self.place[:, 1])
        misses[(t < self.track_t[0]) | (t > self.track_t[-1])] = SEEN_M
        return np.minimum(misses, SEEN_M)

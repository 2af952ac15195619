"""Aligns a team's recordings to one clock: stated, shared, or estimated from mutual sightings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from tools.report.clock_search import ClockFit, best_correction
from tools.report.run_log import RunLog

LONGEST_S = 3 * 86400.0
"""Longest time a report may span: its figures sample all of it, some 80 MB a robot and day."""
YEAR_S = 365.25 * 86400.0


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
    poses, however far apart they are. Returns one note per run.

    Raises AlignmentError for a stated robot without a recording, for a run whose clock is far from
    all others' and cannot be found, and for recordings too far apart for one report.
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
    notes = _set_clocks(runs, stated, trust_host=trust_host)
    first = min(run.shift for run in runs)
    for run in runs:
        run.shift -= first
    span = max(run.shift + run.end for run in runs)
    if span > LONGEST_S:
        raise AlignmentError(
            f"the recordings span {_words(span)}, a report at most {_words(LONGEST_S)}: report "
            "them apart, or state what to add to a clock, e.g. --offset robot2=-3600"
        )
    return notes


def _set_clocks(
    runs: Sequence[RunLog], stated: Mapping[str, float], *, trust_host: bool
) -> list[ClockNote]:
    """Correct each run's shift by the runs settled before it; the surest goes first."""
    notes: dict[int, ClockNote] = {}
    while open_runs := [number for number in range(len(runs)) if number not in notes]:
        settled = [runs[number] for number in notes]
        fits: dict[int, ClockFit] = {}
        for number in open_runs:
            run = runs[number]
            note = _known_clock(run, settled, stated, trust_host=trust_host)
            if note is not None:
                notes[number] = note
                break
            fits[number] = best_correction(run, [each for each in settled if each.name != run.name])
        else:
            surest = max(fits, key=lambda number: fits[number].support)
            if fits[surest].correction is None:
                return _with_wall_clocks(runs, notes, fits)
            notes[surest] = _fitted(runs[surest], fits[surest])
    return [notes[number] for number in range(len(runs))]


def _fitted(run: RunLog, fit: ClockFit) -> ClockNote:
    """Correct one run's shift by sightings."""
    assert fit.correction is not None
    run.shift += fit.correction
    return ClockNote(run.name, fit.correction, "mutual sightings", fit.residual)


def _with_wall_clocks(
    runs: Sequence[RunLog], notes: Mapping[int, ClockNote], fits: Mapping[int, ClockFit]
) -> list[ClockNote]:
    """Return the notes of all runs; those that nothing tells keep their wall clocks, if credible.

    Raises AlignmentError for one that is not.
    """
    for number, fit in fits.items():
        _check_overlap(runs[number], runs, fit)
    return [
        notes.get(number) or ClockNote(run.name, 0.0, f"wall clock: {fits[number].trouble}")
        for number, run in enumerate(runs)
    ]


def _known_clock(
    run: RunLog, settled: Sequence[RunLog], stated: Mapping[str, float], *, trust_host: bool
) -> ClockNote | None:
    """Correct one run's shift where no sightings are needed; return how, None if they are."""
    before = run.shift
    if run.name in stated:
        run.shift += stated[run.name]
        return ClockNote(run.name, stated[run.name], "stated")
    if not settled:
        return ClockNote(run.name, 0.0, "its clock is the team's")
    if not trust_host:
        return None
    for other in settled:
        if run.header.boot and run.header.boot == other.header.boot:
            apart = (run.header.start_monotonic_ns - other.header.start_monotonic_ns) / 1e9
            run.shift = other.shift + apart
            return ClockNote(run.name, run.shift - before, "same host, same monotonic clock")
    if run.header.source == settled[0].header.source == "bench":
        return ClockNote(run.name, 0.0, "same bench, same virtual clock")
    return None


def _check_overlap(run: RunLog, runs: Sequence[RunLog], fit: ClockFit) -> None:
    """Raise AlignmentError if by its wall clock a run was alone: the clock must be wrong."""
    gaps = {
        max(other.shift - run.shift - run.end, run.shift - other.shift - other.end): other
        for other in runs
        if other.name != run.name
    }
    if gaps and min(gaps) > 0.0:
        ahead = gaps[min(gaps)].shift - run.shift
        raise AlignmentError(
            f"{run.path}: by its clock {_words(min(gaps))} from all other robots' recordings, and "
            f"{fit.trouble}; state what to add to its clock: --offset {run.name}={ahead:.0f} if "
            f"they began together, --offset {run.name}=0 if it is right"
        )


def _words(seconds: float) -> str:
    """Return a long time in the largest fitting unit."""
    for unit, size in (("years", YEAR_S), ("days", 86400.0), ("hours", 3600.0)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds:.0f} s"

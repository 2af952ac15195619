"""The times of a log's lines: stamps that are missing, and clocks that were set meanwhile."""

from __future__ import annotations

from collections.abc import Sequence

from maps.input_limits import MAX_PAUSE_S

NOMINAL_STEP_S = 0.1
"""From a line to the next where the stamps do not say: a Pioneer reports ten times a second."""


def continuous_times(stamps: Sequence[float | None]) -> tuple[list[float], int, int]:
    """Return times, s, of lines by their stamps, the jumps of the clock, and stamps missing.

    A line without a stamp is NOMINAL_STEP_S after the one before. A jump of more than MAX_PAUSE_S
    either way that lasts is a clock that was set: the times go on from the line before. A single
    line far off is not: one far ahead gets the time of the line before, one far behind keeps its
    own, as loggers stamp repeated lines with 0.
    """
    times: list[float] = []
    last: float | None = None
    shift, jumps, missing = 0.0, 0, 0
    for number, stamp in enumerate(stamps):
        if stamp is None:
            missing += 1
            last = 0.0 if last is None else last + NOMINAL_STEP_S
            times.append(last)
            continue
        t = stamp + shift
        if last is not None and abs(t - last) > MAX_PAUSE_S:
            if _lasts(stamps, number, last - shift):
                jumps += 1
                shift += last + NOMINAL_STEP_S - t
                t = last + NOMINAL_STEP_S
            else:
                times.append(min(t, last))
                continue
        last = t
        times.append(t)
    return times, jumps, missing


def _lasts(stamps: Sequence[float | None], number: int, before: float) -> bool:
    """Whether the next stamp after a jump is as far from the one before the jump."""
    for stamp in stamps[number + 1 : number + 4]:
        if stamp is not None:
            return abs(stamp - before) > MAX_PAUSE_S
    return True

"""The same thing again and again: handles, threads and memory must stay as they were.

What a cycle leaves behind is nothing in a test of a minute, and ends a robot after a week.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from tools.campaign.footprint import Footprint, footprint_of

MEMORY_MB = 8.0
"""Growth that is no leak: caches and the allocator's own."""
HANDLES = 3
"""Difference of handles and threads that is no leak: some are just being opened or closed."""
_WARM = 0.2
"""Share of the cycles after which everything has been used once."""


class EnduranceError(ValueError):
    """A cycle did not go as it must; the message says which and how."""


@dataclass(frozen=True, slots=True)
class Trial:
    """Something done ``cycles`` times; ``run`` yields the footprint after each."""

    name: str
    what: str
    cycles: int
    run: Callable[[int], Iterator[Footprint]]


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a trial left behind: footprints after each cycle, when warm and at the end."""

    trial: Trial
    cycles: int
    lasted_s: float
    seen: tuple[Footprint, ...]
    """After each cycle; of one that fails at once, at its beginning."""
    trouble: str = ""

    @property
    def warm(self) -> Footprint:
        """After the share of the cycles after which everything has been used once."""
        return self.seen[int(_WARM * len(self.seen))]

    @property
    def end(self) -> Footprint:
        """After the last cycle."""
        return self.seen[-1]

    @property
    def complaints(self) -> list[str]:
        """What was not flat."""
        found = [self.trouble] if self.trouble else []
        if abs(self.end.handles - self.warm.handles) > HANDLES:
            found.append("handles not flat")
        if abs(self.end.threads - self.warm.threads) > HANDLES:
            found.append("threads not flat")
        if self.end.memory_mb - self.warm.memory_mb > MEMORY_MB:
            found.append("memory not flat")
        return found


def endure(trial: Trial, cycles: int, progress: Callable[[int], None]) -> Outcome:
    """Run a trial; a cycle that fails ends it, and is its trouble."""
    started = time.monotonic()
    seen: list[Footprint] = []
    trouble = ""
    try:
        for footprint in trial.run(cycles):
            seen.append(footprint)
            progress(len(seen))
    except EnduranceError as error:
        trouble = f"cycle {len(seen) + 1}: {error}"
    lasted = time.monotonic() - started
    kept = tuple(seen) or (footprint_of(os.getpid()),)
    return Outcome(trial, len(kept), lasted, kept, trouble)


HEADINGS = ("trial", "times", "took s", "handles", "threads", "memory MB", "verdict")


def markdown(outcomes: Sequence[Outcome]) -> str:
    """Return the table in Markdown; figures are those when warm and at the end."""
    rows = [HEADINGS, tuple("---" for _ in HEADINGS), *map(_row, outcomes)]
    return "".join(f"| {' | '.join(cells)} |\n" for cells in rows)


def _row(outcome: Outcome) -> tuple[str, ...]:
    warm, end = outcome.warm, outcome.end
    return (
        outcome.trial.what,
        str(outcome.cycles),
        f"{outcome.lasted_s:.0f}",
        f"{warm.handles}, {end.handles}",
        f"{warm.threads}, {end.threads}",
        f"{warm.memory_mb:.1f}, {end.memory_mb:.1f}",
        "; ".join(outcome.complaints) or "ok",
    )

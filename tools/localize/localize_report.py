"""The localizer's studies by name, and their tables as text."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from localization.settings import LocalizationSettings
from tools.localize.localize import Progress
from tools.localize.localize_study import StudyLog, Table, accuracy
from tools.localize.localize_trials import frozen_turns, global_starts, kidnaps, slips

Study = Callable[[Sequence[StudyLog], int, LocalizationSettings, Progress], Table]
"""Takes logs, number of seeds or trials, settings, progress in runs done."""


def _accuracy(
    logs: Sequence[StudyLog], seeds: int, settings: LocalizationSettings, progress: Progress
) -> Table:
    return accuracy(logs, seeds, settings=settings, progress=progress)


def _hold_out(
    logs: Sequence[StudyLog], seeds: int, settings: LocalizationSettings, progress: Progress
) -> Table:
    return accuracy(logs, seeds, hold_out=True, settings=settings, progress=progress)


def _frozen_over(degrees: float) -> Study:
    def study(
        logs: Sequence[StudyLog], trials: int, settings: LocalizationSettings, progress: Progress
    ) -> Table:
        return frozen_turns(logs, trials, settings, progress, math.radians(degrees))[0]

    return study


SEEDED: dict[str, Study] = {"accuracy": _accuracy, "hold-out": _hold_out}
"""Studies that run every log with every seed."""

TRIED: dict[str, Study] = {
    "global": lambda *work: global_starts(*work)[0],
    "kidnap": lambda *work: kidnaps(*work)[0],
    "frozen": lambda *work: frozen_turns(*work)[0],
    "frozen-60": _frozen_over(60.0),
    "frozen-90": _frozen_over(90.0),
    "slip": lambda *work: slips(*work)[0],
}
"""Studies whose trials are spread over the logs."""

STUDIES = (*SEEDED, *TRIED)


def run_count(name: str, logs: int, seeds: int, trials: int) -> int:
    """Return the number of runs of a study."""
    return logs * seeds if name in SEEDED else trials


def run_study(
    name: str, logs: Sequence[StudyLog], seeds: int, trials: int, progress: Progress
) -> Table:
    """Run a study of ``STUDIES`` with the default settings; progress counts its runs."""
    settings = LocalizationSettings()
    if name in SEEDED:
        return SEEDED[name](logs, seeds, settings, progress)
    return TRIED[name](logs, trials, settings, progress)


def format_table(table: Table) -> str:
    """Return a table, one row or more, as aligned text, numbers to the right."""
    heading = list(table[0])
    body = [[_cell(row[column]) for column in heading] for row in table]
    widths = [max(len(cells[i]) for cells in [heading, *body]) for i in range(len(heading))]
    lines = []
    for cells in [heading, *body]:
        first, *others = [
            cell.ljust(width) if i == 0 else cell.rjust(width)
            for i, (cell, width) in enumerate(zip(cells, widths, strict=True))
        ]
        lines.append("  ".join((first, *others)).rstrip())
    return "\n".join(lines)


def _cell(value: object) -> str:
    return f"{value:.3f}" if isinstance(value, float) else str(value)

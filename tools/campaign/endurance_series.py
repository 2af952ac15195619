"""The series of an endurance trial: footprints after each cycle, as a table or a figure."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

from maps.whole_file import whole_file
from tools.campaign.endurance import EnduranceError, Outcome

COLUMNS = ("trial", "cycle", "handles", "threads", "memory_mb")
FIGURES = (".svg", ".png", ".pdf")
_PANELS = (("handles", "handles"), ("threads", "threads"), ("memory_mb", "memory, MB"))


def check_series(path: Path) -> None:
    """Raise EnduranceError for a file that is neither table nor figure, before hours are spent."""
    if path.suffix not in (".csv", *FIGURES):
        raise EnduranceError(f"{path}: name it .csv, or {', '.join(FIGURES)} for a figure")


def write_series(outcomes: Sequence[Outcome], path: Path) -> None:
    """Write the footprints of all cycles; raises OSError."""
    if path.suffix == ".csv":
        _write_table(outcomes, path)
    else:
        _draw(outcomes, path)


def _write_table(outcomes: Sequence[Outcome], path: Path) -> None:
    with whole_file(path) as part, part.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for outcome in outcomes:
            for cycle, held in enumerate(outcome.seen, 1):
                numbers = held.handles, held.threads, f"{held.memory_mb:.2f}"
                writer.writerow((outcome.trial.name, cycle, *numbers))


def _draw(outcomes: Sequence[Outcome], path: Path) -> None:
    """Draw a panel for each figure and a line for each trial, over the share of its cycles."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.0, 6.0), layout="constrained")
    panels = figure.subplots(len(_PANELS), sharex=True)
    for axes, (name, words) in zip(panels, _PANELS, strict=True):
        for outcome in outcomes:
            count = len(outcome.seen)
            shares = [100.0 * number / count for number in range(1, count + 1)]
            axes.plot(shares, [getattr(held, name) for held in outcome.seen])
        axes.set_ylabel(words)
        axes.set_ylim(bottom=0.0)
        axes.grid(alpha=0.3)
    panels[-1].set_xlabel("cycles, %")
    names = [f"{outcome.trial.name}, {outcome.cycles} times" for outcome in outcomes]
    figure.legend(panels[0].lines, names, loc="outside upper center", ncols=2)
    with whole_file(path) as part:
        figure.savefig(part)

"""Differences between two settings of a study, paired by seed."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from maps.whole_file import whole_file
from tools.logs.csv_cells import csv_cells
from tools.studies.case_names import CaseNames
from tools.studies.study import Case, Result
from tools.studies.study_table import COLUMNS, Extract, Summary, summarize


@dataclass(frozen=True)
class Difference:
    """A case less the one with the first value of the last varied key, all else equal."""

    case: Case
    base: Case
    figures: Mapping[str, Summary | None]
    """Mean difference with its interval, over the seeds that both have a figure of."""


def differences(results: Sequence[Result], names: CaseNames) -> list[Difference]:
    """Return each case's difference from its base; empty if nothing is varied."""
    runs: dict[Case, dict[int, Result]] = {}
    for result in results:
        runs.setdefault(result.run.case, {})[result.run.seed] = result
    bases: dict[str, Case] = {}
    found = []
    for case in runs:
        base = bases.setdefault(names.row(case), case)
        if base is not case:
            figures = {
                name: _paired(runs[case], runs[base], extract) for name, extract in COLUMNS.items()
            }
            found.append(Difference(case, base, figures))
    return found


def _paired(
    runs: Mapping[int, Result], base: Mapping[int, Result], extract: Extract
) -> Summary | None:
    """Return the mean of the differences of equal seeds, which share what chance does."""
    pairs = [
        (extract(runs[seed].figures), extract(base[seed].figures)) for seed in runs.keys() & base
    ]
    both = [a - b for a, b in pairs if a is not None and b is not None]
    return summarize(np.array(sorted(both), dtype=np.float64))


def write_differences(found: Sequence[Difference], names: CaseNames, path: Path) -> None:
    """Write one line for each difference and figure."""
    with whole_file(path) as part, part.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        heads = ["case", "setting", "less", "figure", "mean", "half_width", "seeds"]
        writer.writerow(csv_cells(heads))
        for each in found:
            place = [names.row(each.case), names.column(each.case), names.column(each.base)]
            for name, summary in each.figures.items():
                if summary is not None:
                    values = [name, summary.mean, summary.half_width, summary.runs]
                    writer.writerow(csv_cells([*place, *values]))

"""A study's figures as Markdown tables, for a README: settings as rows, figures as columns."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from maps.whole_file import write_whole
from tools.studies.case_names import CaseNames
from tools.studies.study import Case
from tools.studies.study_plot import Rows
from tools.studies.study_table import Summary


def write_markdown(rows: Rows, names: CaseNames, path: Path) -> None:
    """Write a table for each combination of the varied keys but the last; raises OSError.

    A line for each value of the last varied key, a column for each figure that there is.
    """
    grouped: dict[str, list[Case]] = {}
    for case in rows:
        grouped.setdefault(names.row(case), []).append(case)
    parts = [f"{row or names.title}:\n\n{_table(own, rows, names)}" for row, own in grouped.items()]
    write_whole(path, "\n".join(parts))


def _table(cases: Sequence[Case], rows: Rows, names: CaseNames) -> str:
    figures = [name for name in rows[cases[0]] if any(rows[case][name] for case in cases)]
    head = [names.column_key, *(name.replace("_", " ") for name in figures)]
    body = [[names.column(case), *(_cell(rows[case][name]) for name in figures)] for case in cases]
    return "".join(f"| {' | '.join(line)} |\n" for line in (head, ["---"] * len(head), *body))


def _cell(summary: Summary | None) -> str:
    return "" if summary is None else str(summary)

"""Plots of a study: each figure against the cases, with its 95 % confidence band."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tools.report import style
from tools.studies.case_names import CaseNames
from tools.studies.study import Case
from tools.studies.study_table import COLUMNS, Summary

mpl.use("svg")

Rows = Mapping[Case, Mapping[str, Summary | None]]

_PER_ROW = 3
_WIDTH = 5.0
_ROW_HEIGHT = 0.24
"""Inches of height for a row's name, and for each of its marks."""
_FRAME_HEIGHT = 0.9
_SPREAD = 0.7
"""Share of a row's height over which its colours are spread."""


def plot_study(rows: Rows, names: CaseNames, folder: Path) -> None:
    """Write ``study.svg``, ``.png`` and ``.pdf`` with a panel per figure; raises OSError."""
    panels = _panels(rows)
    count = -(-len(panels) // _PER_ROW)
    figure = Figure(
        figsize=(_WIDTH * _PER_ROW, _panel_height(rows, names) * count + 0.6), layout="constrained"
    )
    grid = figure.subplots(count, _PER_ROW, squeeze=False).ravel()
    for axes, name in zip(grid, panels, strict=False):
        _draw(axes, name, rows, names)
    for axes in grid[len(panels) :]:
        axes.set_visible(False)
    _finish(figure, grid[0], names)
    figure.draw_without_rendering()
    figure.set_layout_engine("none")  # the layout takes long, and is the same in every format
    for form in style.FORMATS:
        style.save(figure, folder / f"study.{form}")


def plot_figures(rows: Rows, names: CaseNames, folder: Path, form: str) -> list[Path]:
    """Write each figure alone, in a format; return the files. Raises OSError."""
    files = []
    for name in _panels(rows):
        figure = Figure(figsize=(_WIDTH, _panel_height(rows, names) + 0.6), layout="constrained")
        axes = figure.subplots()
        _draw(axes, name, rows, names)
        _finish(figure, axes, names)
        files.append(folder / f"{name}.{form}")
        style.save(figure, files[-1])
    return files


def _panels(rows: Rows) -> list[str]:
    return [name for name in COLUMNS if any(row[name] for row in rows.values())]


def _panel_height(rows: Rows, names: CaseNames) -> float:
    marks = len({names.row(case) for case in rows}) * (1 + len({names.column(c) for c in rows}) / 2)
    return max(1.8, _FRAME_HEIGHT + _ROW_HEIGHT * marks)


def _draw(axes: Axes, name: str, rows: Rows, names: CaseNames) -> None:
    """Draw a figure: rows by all varied keys but the last, colours by the last."""
    lines = list(dict.fromkeys(names.row(case) for case in rows))
    colours = list(dict.fromkeys(names.column(case) for case in rows))
    for number, colour in enumerate(colours):
        offset = _SPREAD * ((number + 0.5) / len(colours) - 0.5)
        points = [
            (summary.mean, lines.index(names.row(case)) + offset, summary.half_width)
            for case, row in rows.items()
            if names.column(case) == colour and (summary := row[name])
        ]
        _marks(axes, points, f"C{number % 10}", colour)
    axes.set_yticks(range(len(lines)), lines)
    axes.set_ylim(len(lines) - 0.5, -0.5)
    axes.set_xlabel(name)
    axes.grid(axis="x", alpha=0.3)


def _marks(
    axes: Axes, points: Sequence[tuple[float, float, float]], colour: str, label: str
) -> None:
    """Draw (mean, row, half width) of one colour; a half width that is nan has no bar."""
    means, places, bands = ([point[i] for point in points] for i in range(3))
    bars = [0.0 if band != band else band for band in bands]
    axes.errorbar(means, places, xerr=bars, fmt="o", ms=4, capsize=3, color=colour, label=label)


def _finish(figure: Figure, axes: Axes, names: CaseNames) -> None:
    """Add the title of what all cases share and, if colours mean anything, their legend."""
    if names.title:
        figure.suptitle(names.title, fontsize="medium")
    if names.varied:
        handles, labels = axes.get_legend_handles_labels()
        figure.legend(handles, labels, title=names.column_key, loc="outside lower center", ncols=6)

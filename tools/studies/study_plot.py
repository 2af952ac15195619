"""Plots of a study: each figure against the cases, with its 95 % confidence band."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from tools.studies.study import Case
from tools.studies.study_table import COLUMNS, Summary

mpl.use("svg")

_PER_ROW = 3


def plot_study(rows: Mapping[Case, Mapping[str, Summary | None]], path: Path) -> None:
    """Write one SVG with a panel per figure; raises OSError if it cannot be written."""
    panels = [name for name in COLUMNS if any(row[name] for row in rows.values())]
    count = -(-len(panels) // _PER_ROW)
    figure = Figure(figsize=(5.0 * _PER_ROW, 3.2 * count), layout="constrained")
    grid = figure.subplots(count, _PER_ROW, squeeze=False).ravel()
    labels = [str(case) for case in rows]
    for axes, name in zip(grid, panels, strict=False):
        summaries = [row[name] for row in rows.values()]
        means = np.array([s.mean if s else np.nan for s in summaries])
        bands = np.nan_to_num([s.half_width if s else np.nan for s in summaries])
        axes.errorbar(means, range(len(means)), xerr=bands, fmt="o", capsize=4)
        axes.set_yticks(range(len(labels)), labels)
        axes.invert_yaxis()
        axes.set_xlabel(name)
        axes.grid(axis="x", alpha=0.3)
    for axes in grid[len(panels) :]:
        axes.set_visible(False)
    figure.savefig(path)

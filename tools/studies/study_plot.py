"""Plots of a study: each figure against the cases, with its 95 % confidence band."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

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


def plot_trade_off(
    rows: Mapping[Case, Mapping[str, Summary | None]], bounds: Mapping[str, Any], path: Path
) -> None:
    """Write one SVG: probability of detection in 60 s over the worst idleness, settled.

    A panel each for the intruder who watches his place and for the one who sees all robots. bounds:
    ``intruder_bound`` of a run: what no patrol exceeds, and the optimum of a team that turns
    together, for the one who sees all.
    """
    figure = Figure(figsize=(11.0, 4.5), layout="constrained")
    for axes, kind in zip(figure.subplots(1, 2), ("watcher", "all_knowing"), strict=True):
        for number, (case, row) in enumerate(rows.items(), 1):
            worst, seen = row["settled_idleness_worst_s"], row[f"settled_{kind}_60s"]
            if worst and seen:
                bars = {
                    "xerr": np.nan_to_num(worst.half_width),
                    "yerr": np.nan_to_num(seen.half_width),
                }
                axes.errorbar(worst.mean, seen.mean, fmt="o", label=f"{number} {case}", **bars)
                axes.annotate(
                    str(number), (worst.mean, seen.mean), (4, 4), textcoords="offset points"
                )
        axes.axhline(bounds["random"]["60"], color="0.6", linestyle="--", label="no patrol exceeds")
        optimum = bounds["turning_together"]["60"]
        if kind == "all_knowing" and optimum is not None:
            axes.axhline(optimum, color="0.6", linestyle=":", label="Agmon's optimum")
        axes.set(xlabel="worst idleness, s", ylabel=f"{kind.replace('_', ' ')}: seen in 60 s")
        axes.set_ylim(-0.03, 1.05)
        axes.legend(fontsize=6)
    figure.savefig(path)

"""Plot of a study: detection against worst idleness, with what no patrol exceeds."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tools.report import style
from tools.studies.case_names import CaseNames
from tools.studies.study import Case
from tools.studies.study_plot import Rows

_PANEL_HEIGHT = 4.5  # inches
_NAME_HEIGHT = 0.17  # inches of a case's name below the panels
_SIDE_BY_SIDE = 2  # names


def plot_trade_off(rows: Rows, names: CaseNames, bounds: Mapping[str, Any], folder: Path) -> None:
    """Write ``trade_off.svg``, ``.png`` and ``.pdf``; raises OSError.

    Probability of detection in 60 s over the worst idleness, settled: a panel each for the intruder
    who watches his place and for the one who sees all robots. bounds: ``intruder_bound`` of a run:
    what no patrol exceeds, and the optimum of a team that turns together, for the one who sees all.
    """
    height = _PANEL_HEIGHT + _NAME_HEIGHT * (len(rows) + 2) / _SIDE_BY_SIDE
    figure = Figure(figsize=(11.0, height), layout="constrained")
    panels = figure.subplots(1, 2)
    for axes, kind in zip(panels, ("watcher", "all_knowing"), strict=True):
        _draw_cases(axes, rows, names, kind)
        axes.axhline(bounds["random"]["60"], color="0.6", linestyle="--", label="no patrol exceeds")
        optimum = bounds["turning_together"]["60"]
        if kind == "all_knowing" and optimum is not None:
            axes.axhline(optimum, color="0.6", linestyle=":", label="Agmon's optimum")
        axes.set(xlabel="worst idleness, s", ylabel=f"{kind.replace('_', ' ')}: seen in 60 s")
        axes.set_ylim(-0.03, 1.05)
    told = dict(zip(*reversed(panels[0].get_legend_handles_labels()), strict=True))
    told |= dict(zip(*reversed(panels[1].get_legend_handles_labels()), strict=True))
    figure.legend(
        told.values(), told.keys(), fontsize=7, ncols=_SIDE_BY_SIDE, loc="outside lower center"
    )
    for form in style.FORMATS:
        style.save(figure, folder / f"trade_off.{form}")


def _draw_cases(axes: Axes, rows: Rows, names: CaseNames, kind: str) -> None:
    """Draw a numbered point with its intervals for each case that has both figures."""
    for number, (case, row) in enumerate(rows.items(), 1):
        worst, seen = row["settled_idleness_worst_s"], row[f"settled_{kind}_60s"]
        if worst and seen:
            bars = {
                "xerr": np.nan_to_num(worst.half_width),
                "yerr": np.nan_to_num(seen.half_width),
            }
            label = f"{number} {_name(case, names)}"
            axes.errorbar(worst.mean, seen.mean, fmt="o", label=label, **bars)
            axes.annotate(str(number), (worst.mean, seen.mean), (4, 4), textcoords="offset points")


def _name(case: Case, names: CaseNames) -> str:
    """Return what is varied in a case; what all have in common is left out."""
    last = f"{names.column_key} {names.column(case)}".strip()
    return ", ".join(filter(None, (names.row(case), last)))

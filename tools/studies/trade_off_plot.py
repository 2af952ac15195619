"""Plot of a study: detection against worst idleness, with what no patrol exceeds."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from tools.report import style
from tools.studies.study_plot import Rows


def plot_trade_off(rows: Rows, bounds: Mapping[str, Any], folder: Path) -> None:
    """Write ``trade_off.svg``, ``.png`` and ``.pdf``; raises OSError.

    Probability of detection in 60 s over the worst idleness, settled: a panel each for the intruder
    who watches his place and for the one who sees all robots. bounds: ``intruder_bound`` of a run:
    what no patrol exceeds, and the optimum of a team that turns together, for the one who sees all.
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
    for form in style.FORMATS:
        style.save(figure, folder / f"trade_off.{form}")

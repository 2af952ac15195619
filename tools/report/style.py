"""Style of a report's figures: colors, sizes, helpers, conversion to inline SVG."""

from __future__ import annotations

import io
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from markupsafe import Markup
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator

from maps.whole_file import whole_file
from robot_agent.patrol.actions import Action
from tools.report.run_log import Floats

mpl.use("svg")

INK, QUIET, RULE = "#1f2933", "#66727f", "#e3e7ec"
ROBOTS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#8a6d00", "#56b4e9")
"""Okabe and Ito's colors, distinguishable with any kind of color vision."""
ACTIONS = {
    str(Action.REACH_FRONTIER): "#a5b1bf",
    str(Action.KEEP_GOING): "#5aa469",
    str(Action.PATROL_CLOCKWISE): "#3f7fce",
    str(Action.PATROL_COUNTER_CLOCKWISE): "#e9a23b",
    str(Action.AVOID_TEAMMATE): "#c8323f",
}
ALARM = "#c8323f"
ZONE = "#00708f"
WIDTH = 11.0
"""Width of a figure, inches."""
DPI = 150
"""Resolution of a figure as PNG."""
FORMATS = ("svg", "png", "pdf")
"""Of figures that are written as files."""
POINTS = 1600
"""Most points of a line: more are not distinguishable."""

RC: Any = {
    "svg.fonttype": "none",
    "svg.hashsalt": "patrol",
    "path.simplify": True,
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 9.5,
    "axes.edgecolor": "#b9c2cc",
    "axes.labelcolor": QUIET,
    "axes.titlesize": 10,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.8,
    "axes.axisbelow": True,
    "xtick.color": QUIET,
    "ytick.color": QUIET,
    "text.color": INK,
    "grid.color": RULE,
    "grid.linewidth": 0.8,
    "lines.linewidth": 1.3,
    "lines.solid_capstyle": "round",
    "legend.frameon": False,
    "figure.facecolor": "none",
    "axes.facecolor": "none",
}


def words(name: str) -> str:
    """Return an identifier with blanks for display."""
    return name.replace("_", " ").replace("counter clockwise", "counter-clockwise")


def clock(t: float) -> str:
    """Return a team time, s, as m:ss."""
    return f"{int(t) // 60}:{int(t) % 60:02d}"


def new_figure(height: float, width: float = WIDTH) -> Figure:
    """Return an empty figure, sizes in inches."""
    return Figure(figsize=(width, height), layout="constrained")


def rows(count: int, each: float, max_height: float = 12.0) -> tuple[Figure, list[Axes]]:
    """Return a figure of ``count`` rows with a shared time axis, and the rows' axes.

    each, max_height: heights of a row and of the figure, inches.
    """
    figure = new_figure(min(0.55 + each * count, max_height))
    axes = figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0].tolist()
    return figure, axes


def time_axis(axes: Axes, start: float, end: float) -> None:
    """Label an axis with team time as m:ss."""
    axes.set_xlim(start, max(end, start + 1.0))
    axes.xaxis.set_major_locator(MaxNLocator(12, steps=[1, 2, 3, 6, 10]))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda t, _: clock(t)))
    axes.grid(axis="x")


def save(figure: Figure, path: Path, **options: Any) -> None:
    """Write a figure as a file, whole or not at all; options: of ``savefig``. Raises OSError."""
    with whole_file(path) as part:
        figure.savefig(part, dpi=DPI, **options)


def round_ticks(count: int) -> MaxNLocator:
    """Return ticks at 1, 2 or 5 times a power of ten, at most so many."""
    return MaxNLocator(count, steps=[1, 2, 5, 10])


def thinned(t: Floats, y: Floats, points: int = POINTS) -> tuple[Floats, Floats]:
    """Return a line with at max_height that many points: minimum and maximum of every interval."""
    if t.size <= points:
        return t, y
    edges = np.linspace(0, t.size, points // 2 + 1).astype(int)
    kept: list[int] = []
    for start, end in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        part = y[start:end]
        if not np.isfinite(part).any():
            kept.append(start)
            continue
        low, high = int(np.nanargmin(part)), int(np.nanargmax(part))
        kept += sorted({start + low, start + high})
    return t[kept], y[kept]


def with_breaks(t: Floats, y: Floats, longest: float) -> tuple[Floats, Floats]:
    """Return a line with a nan inserted where points are farther apart than ``longest`` s."""
    places = np.flatnonzero(np.diff(t) > longest) + 1
    return np.insert(t, places, t[places - 1] + longest / 2), np.insert(y, places, np.nan)


@dataclass(frozen=True, slots=True)
class Drawing:
    """A figure as SVG: the element's attributes, and its content with the end tag."""

    attributes: Markup
    content: Markup


def drawing(figure: Figure) -> Drawing:
    """Return a figure as an SVG element without width and height, which scales with its page."""
    out = io.StringIO()
    with mpl.rc_context(RC):
        figure.savefig(out, format="svg", transparent=True, metadata={"Date": None})
    text = out.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    head, _, content = text.removeprefix("<svg").partition(">")
    attributes = re.sub(r' (?:width|height)="[^"]*"', "", head)
    return Drawing(Markup(attributes), Markup(content))  # noqa: S704 - escaped by Matplotlib


def robot_colors(names: Sequence[str]) -> dict[str, str]:
    """Return the color of each robot by name."""
    return {name: ROBOTS[index % len(ROBOTS)] for index, name in enumerate(names)}

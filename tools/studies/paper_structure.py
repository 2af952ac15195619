"""The paper's figure 1: behaviors are composed to actions, of which the supervisor chooses one."""

from __future__ import annotations

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch

from tools.report import style

_INPUTS = ("sensors:\npose, closest teammate", "border, map")
_BEHAVIORS = (
    "Reach Frontier",
    "Patrol Frontier\nClockwise",
    "Patrol Frontier\nCounter-clockwise",
    "Teammate Avoidance",
)
_ACTIONS = ("Reach Frontier", "Keep Going", "Patrol CW", "Patrol CCW", "Avoid Teammate")
_COMPOSED_OF = ((0,), (0, 1, 2), (0, 1), (0, 2), (0, 3))
"""Behaviors of each action."""
_WIDTH, _HEIGHT = 2.3, 0.75


def structure() -> Figure:
    """Return the figure: from sensors over supervisor, actions and behaviors to a velocity."""
    with mpl.rc_context(style.RC):
        figure = style.new_figure(4.6)
        axes = figure.subplots()
        axes.set_axis_off()
        axes.set_xlim(-0.2, 14.8)
        axes.set_ylim(-0.5, 6.3)
        _column(axes, 0.0, "", _INPUTS, (3.6, 1.6))
        _box(axes, 3.1, 2.6, "supervisor:\nfuzzy rules", style.ROBOTS[0])
        rows = tuple(5.2 - 1.2 * number for number in range(len(_ACTIONS)))
        _column(axes, 6.2, "actions: one at a time", _ACTIONS, rows)
        places = tuple(4.8 - 1.35 * number for number in range(len(_BEHAVIORS)))
        _column(axes, 9.3, "elementary behaviors", _BEHAVIORS, places)
        _box(axes, 12.3, 2.6, "null-space-based\ncomposition:\nvelocity", style.ROBOTS[2])
        for y in (3.6, 1.6):
            _arrow(axes, (_WIDTH, y), (3.1, 2.6))
        for y, parts in zip(rows, _COMPOSED_OF, strict=True):
            _arrow(axes, (3.1 + _WIDTH, 2.6), (6.2, y))
            for part in parts:
                _arrow(axes, (6.2 + _WIDTH, y), (9.3, places[part]))
        for y in places:
            _arrow(axes, (9.3 + _WIDTH, y), (12.3, 2.6))
    return figure


def _column(
    axes: Axes, x: float, title: str, names: tuple[str, ...], rows: tuple[float, ...]
) -> None:
    axes.text(x + _WIDTH / 2, 5.95, title, ha="center", fontweight="bold")
    for name, y in zip(names, rows, strict=True):
        _box(axes, x, y, name, style.QUIET)


def _box(axes: Axes, x: float, y: float, text: str, color: str) -> None:
    """Draw a box whose left edge has its middle at (x, y)."""
    corner = x, y - _HEIGHT / 2
    axes.add_patch(
        FancyBboxPatch(
            corner, _WIDTH, _HEIGHT, "round,pad=0,rounding_size=0.1", fill=False, edgecolor=color
        )
    )
    axes.text(x + _WIDTH / 2, y, text, ha="center", va="center", fontsize=8)


def _arrow(axes: Axes, start: tuple[float, float], end: tuple[float, float]) -> None:
    axes.annotate(
        "", xy=end, xytext=start, arrowprops={"arrowstyle": "-|>", "color": style.QUIET, "lw": 0.7}
    )

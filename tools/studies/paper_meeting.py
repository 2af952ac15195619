"""The paper's figure 6: a sequence of the whole team in which two robots meet and turn back."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tools.metrics.metrics import ARRIVED_M
from tools.report import style
from tools.studies.paper import PaperRun, turns
from tools.studies.paper_map import draw_map, draw_robot, heading_of

_AROUND_S = (-9.0, -3.0, 3.0, 9.0)  # pictures, from the moment at which the robots meet
_TRAIL_S = 6.0  # drawn behind each robot


def meeting_sequence(run: PaperRun) -> Figure | None:
    """Return the figure of a meeting after which both go on, apart; None without one.

    It is the first with the whole team on the border, else the first. The robots' true positions,
    each with the way of its last 6 s and an arrow of forward motion.
    """
    found = [turn for turn in turns(run) if turn.opposite and turn.parted]
    if not found:
        return None
    met = next((turn for turn in found if _all_on_border(run, turn.t)), found[0])
    with mpl.rc_context(style.RC):
        figure = style.new_figure(8.0)
        figure.suptitle(f"{met.robots[0]} and {met.robots[1]} meet and turn back", fontsize=11)
        for axes, after in zip(figure.subplots(2, 2).ravel(), _AROUND_S, strict=True):
            _draw_moment(axes, run, met.t + after)
        lines, names = figure.axes[0].get_legend_handles_labels()
        figure.legend(lines, names, loc="outside lower center", ncols=len(names))
    return figure


def _all_on_border(run: PaperRun, t: float) -> bool:
    """Return whether all robots have reached the border in the first picture of a meeting at t."""
    assert run.folder.border is not None
    first = int(np.searchsorted(run.runs[0].t, t + _AROUND_S[0] - _TRAIL_S))
    places = np.array([each.position[first] for each in run.runs])
    return bool((run.folder.border.project_many(places)[1] <= ARRIVED_M).all())


def _draw_moment(axes: Axes, run: PaperRun, t: float) -> None:
    draw_map(axes, run.folder, run.runs)
    axes.set_title(f"t = {t:.1f} s")
    for each, color in zip(run.runs, style.ROBOTS, strict=False):
        begin, now = np.searchsorted(each.t, (t - _TRAIL_S, t)).tolist()
        now = min(now, len(each.t) - 1)
        way = each.position[begin : now + 1]
        axes.plot(*way.T, color=color, linewidth=2.5, alpha=0.5, label=each.name)
        x, y = each.position[now].tolist()
        draw_robot(axes, (x, y), heading_of(run.folder, each, now), color)
    axes.set_xlabel("x, m")
    axes.set_ylabel("y, m")

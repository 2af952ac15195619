"""Draws the paper's figures 4, 5 and 6 from a run of its experiment."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from maps.map_folder import MapFolder
from maps.occupancy_map import OCCUPIED
from maps.whole_file import whole_file
from robot_agent.patrol.actions import Action
from tools.metrics.metrics import Meeting, RobotRun, distance_from_border
from tools.report import style
from tools.studies.paper import PaperRun, turns

_LEVELS = ("ARF", "AKGCW", "AKGCCW", "APCW", "APCCW", "ATA")
_AROUND_S = 12.0  # drawn before and after a meeting
_ARROW_S = 2.0  # between two arrows
_VIEW_M = 4.0  # half the side of the drawn square around a meeting


def write_figures(run: PaperRun, folder: Path) -> bool:
    """Write the figures as SVG and PNG; return False if figure 6 is missing: no robots met."""
    drawn = {
        "distance_from_border": distances(run),
        "actions": actions(run),
        "meeting": meeting(run),
    }
    for name, figure in drawn.items():
        if figure is not None:
            for suffix in ("svg", "png"):
                with whole_file(folder / f"{name}.{suffix}") as part:
                    figure.savefig(part)
    return drawn["meeting"] is not None


def distances(run: PaperRun) -> Figure:
    """Return figure 4: each robot's distance from the border, m, over time."""
    assert run.folder.border is not None
    with mpl.rc_context(style.RC):
        figure, panels = style.rows(len(run.runs), 1.5)
        for axes, each, color in zip(panels, run.runs, style.ROBOTS, strict=False):
            distance = distance_from_border(run.folder.border, each)
            axes.plot(*style.thinned(each.t, distance), color=color)
            axes.axhline(0.1, color=style.ALARM, linewidth=0.8, linestyle="--")
            axes.set_yscale("log")
            axes.set_ylim(1e-4, 10.0)
            axes.set_ylabel("m")
            axes.set_title(f"{each.name}: distance from border (dashed: 0.1 m)")
            style.time_axis(axes, 0.0, float(each.t[-1]))
    return figure


def actions(run: PaperRun) -> Figure:
    """Return figure 5: each robot's action over time, Keep Going split by direction."""
    with mpl.rc_context(style.RC):
        figure, panels = style.rows(len(run.runs), 1.7)
        for axes, each, color in zip(panels, run.runs, style.ROBOTS, strict=False):
            levels = np.array(
                [_level(*row) for row in zip(each.action, each.direction, strict=True)]
            )
            axes.step(each.t, levels, where="post", color=color, linewidth=0.9)
            axes.set_yticks(range(len(_LEVELS)), _LEVELS)
            axes.set_ylim(-0.5, len(_LEVELS) - 0.5)
            axes.set_title(f"{each.name}: action")
            style.time_axis(axes, 0.0, float(each.t[-1]))
    return figure


def _level(action: str, direction: int) -> float:
    name = {
        Action.REACH_FRONTIER.value: "ARF",
        Action.KEEP_GOING.value: "AKGCW" if direction > 0 else "AKGCCW",
        Action.PATROL_CLOCKWISE.value: "APCW",
        Action.PATROL_COUNTER_CLOCKWISE.value: "APCCW",
        Action.AVOID_TEAMMATE.value: "ATA",
    }.get(action)
    return np.nan if name is None else float(_LEVELS.index(name))


def meeting(run: PaperRun) -> Figure | None:
    """Return figure 6: the paths of two robots that meet and turn; None if no two did."""
    times = {turn.t for turn in turns(run) if turn.opposite and turn.parted}
    met = next((each for each in run.meetings if each.t in times), None)
    if met is None:
        return None
    with mpl.rc_context(style.RC):
        figure = style.new_figure(6.5, 6.5)
        axes = figure.subplots()
        _draw_map(axes, run.folder)
        for each, color in zip(run.runs, style.ROBOTS, strict=False):
            _draw_path(axes, each, met, color)
        x, y = _place(run, met)
        axes.set_xlim(x - _VIEW_M, x + _VIEW_M)
        axes.set_ylim(y - _VIEW_M, y + _VIEW_M)
        axes.set_aspect("equal")
        axes.set_xlabel("x, m")
        axes.set_ylabel("y, m")
        axes.set_title(f"{met.robots[0]} and {met.robots[1]} meet at {style.clock(met.t)}")
        axes.legend(loc="lower left")
    return figure


def _place(run: PaperRun, met: Meeting) -> tuple[float, float]:
    pair = [each for each in run.runs if each.name in met.robots]
    index = int(np.searchsorted(pair[0].t, met.t))
    x, y = np.mean([each.position[index] for each in pair], axis=0)
    return float(x), float(y)


def _draw_map(axes: Axes, folder: MapFolder) -> None:
    """Draw walls and border."""
    assert folder.border is not None
    grid = folder.map
    rows, cols = grid.cells.shape
    x, y, resolution = grid.origin.x, grid.origin.y, grid.resolution
    axes.imshow(
        grid.cells == OCCUPIED,
        cmap="Greys",
        vmax=1.3,
        origin="lower",
        interpolation="nearest",
        extent=(x, x + cols * resolution, y, y + rows * resolution),
    )
    axes.plot(*folder.border.polyline(0.05).T, color=style.QUIET, linewidth=0.8, linestyle=":")


def _draw_path(axes: Axes, each: RobotRun, met: Meeting, color: str) -> None:
    """Draw a robot's path around a meeting: a dot at its start, arrows along it."""
    if each.name not in met.robots:
        return
    start, end = np.searchsorted(each.t, (met.t - _AROUND_S, met.t + _AROUND_S))
    way = each.position[start:end]
    # Both paths follow the border: each is shifted a little to be distinguishable.
    aside = 0.06 if each.name == met.robots[0] else -0.06
    way = way + aside
    axes.plot(*way.T, color=color, label=each.name)
    axes.plot(*way[0], "o", color=color)
    step = max(1, round(_ARROW_S / float(each.t[1] - each.t[0])))
    for index in range(step, len(way) - 1, step):
        ahead = way[min(index + 2, len(way) - 1)] - way[index - 1]
        if np.hypot(*ahead) > 0.02:
            axes.annotate(
                "",
                xy=way[index] + 0.2 * ahead / np.hypot(*ahead),
                xytext=way[index],
                arrowprops={"arrowstyle": "-|>", "color": color},
            )

"""Draws the paper's six figures from a run of its experiment."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from robot_agent.patrol.actions import Action
from robot_agent.patrol.patrol import rules_of
from robot_agent.patrol.settings import PatrolSettings
from robot_agent.perception.visibility import VISIBILITY
from tools.metrics.metrics import RobotRun, distance_from_border
from tools.report import style
from tools.studies.paper import MAX_M, PaperRun
from tools.studies.paper_map import draw_map, draw_robot
from tools.studies.paper_meeting import meeting_sequence
from tools.studies.paper_structure import structure
from tools.studies.rules_picture import sets_figure

FORMATS = ("pdf", "png")
_LEVELS = ("ARF", "AKGCW", "AKGCCW", "APCW", "APCCW", "ATA")


def write_figures(run: PaperRun, settings: PatrolSettings, folder: Path) -> bool:
    """Write the figures as PDF and PNG; return False if figure 6 is missing: no robots met."""
    assert run.folder.border is not None
    drawn = {
        "figure_1_structure": structure(),
        "figure_2_membership": sets_figure(rules_of(settings, run.folder.border)),
        "figure_3_scenario": scenario(run),
        "figure_4_distance": distances(run),
        "figure_5_actions": actions(run),
        "figure_6_meeting": meeting_sequence(run),
    }
    for name, figure in drawn.items():
        if figure is not None:
            for suffix in FORMATS:
                style.save(figure, folder / f"{name}.{suffix}", facecolor="white")
    return drawn["figure_6_meeting"] is not None


def scenario(run: PaperRun) -> Figure:
    """Return figure 3: map, border, and the robots with their visibility areas at the start."""
    with mpl.rc_context(style.RC):
        figure = style.new_figure(6.0, 8.0)
        axes = figure.subplots()
        draw_map(axes, run.folder, run.runs)
        for each, color in zip(run.runs, style.ROBOTS, strict=False):
            x, y = each.position[0].tolist()
            axes.add_patch(Circle((x, y), VISIBILITY, facecolor=color, alpha=0.2))
            moved = _first_motion(each)
            draw_robot(axes, (x, y), math.atan2(moved[1], moved[0]), color)
        axes.set_xlabel("x, m")
        axes.set_ylabel("y, m")
    return figure


def _first_motion(run: RobotRun) -> tuple[float, float]:
    """Return the way of a robot from its start until it is 0.3 m away, m."""
    way = run.position - run.position[0]
    index = int(np.argmax(np.hypot(*way.T) > 0.3))
    return float(way[index][0]), float(way[index][1])


def distances(run: PaperRun) -> Figure:
    """Return figure 4: each robot's distance from the border, m, over time; the paper's bound."""
    assert run.folder.border is not None
    with mpl.rc_context(style.RC):
        figure, panels = style.rows(len(run.runs), 2.0)
        for axes, each, color in zip(panels, run.runs, style.ROBOTS, strict=False):
            distance = distance_from_border(run.folder.border, each)
            axes.axhspan(0.0, MAX_M, color=style.ALARM, alpha=0.25, linewidth=0.0)
            axes.plot(*style.thinned(each.t, distance), color=color)
            axes.set_ylim(0.0, None)
            axes.set_ylabel("m")
            axes.yaxis.set_major_locator(style.round_ticks(5))
            axes.set_title(f"{each.name}: distance from border (band: {MAX_M:g} m)")
        _time_axes(panels, run)
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
        _time_axes(panels, run)
    return figure


def _time_axes(panels: Sequence[Axes], run: PaperRun) -> None:
    """Label the common time axis of the panels, s, with round ticks."""
    for axes in panels:
        axes.set_xlim(0.0, float(run.runs[0].t[-1]))
        axes.xaxis.set_major_locator(style.round_ticks(10))
        axes.grid(axis="x")
    panels[-1].set_xlabel("time, s")


def _level(action: str, direction: int) -> float:
    name = {
        Action.REACH_FRONTIER.value: "ARF",
        Action.KEEP_GOING.value: "AKGCW" if direction > 0 else "AKGCCW",
        Action.PATROL_CLOCKWISE.value: "APCW",
        Action.PATROL_COUNTER_CLOCKWISE.value: "APCCW",
        Action.AVOID_TEAMMATE.value: "ATA",
    }.get(action)
    return np.nan if name is None else float(_LEVELS.index(name))

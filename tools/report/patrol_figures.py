"""Figures of the patrol: paths, distance from the border, actions, meetings, idleness."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from itertools import groupby

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Polygon

from maps.occupancy_map import FREE, OCCUPIED
from maps.zone import Zone
from tools.metrics.idleness import longest_of, mean_of
from tools.metrics.metrics import Meeting, RobotRun, action_share
from tools.report import style
from tools.report.team import Team

SHOWN_MEETINGS = 3
AROUND_S = 6.0
"""Time drawn before and after a meeting's closest approach."""
_VIEW_M = 2.6  # half the side of a meeting's picture
_ON_BORDER = 1.0  # m; farther away a robot's abscissa is not drawn
_FLAT = 0.12
"""Distance, m, up to which the axis is linear: usual on patrol."""


def trajectories(team: Team) -> Figure:
    """Draw map, border, every robot's path, references and meetings."""
    colors = style.robot_colors(team.names)
    figure = style.new_figure(style.WIDTH * _aspect(team) * 0.82 + 0.4)
    axes = figure.subplots()
    _draw_map(axes, team)
    for run in team.sampled:
        known = np.flatnonzero(np.isfinite(run.position[:, 0]))
        if not known.size:
            continue
        path = run.position[known[:: max(1, known.size // 4000)]]
        axes.plot(*path.T, color=colors[run.name], lw=1.2, alpha=0.6, label=run.name)
        axes.plot(*path[0], "o", zorder=4, color=colors[run.name], ms=6, mec="white", mew=1.2)
    for log in team.runs:
        if log.reference.size:
            axes.plot(*log.reference[:, :2].T, ".", color=style.INK, ms=1.5, label="reference")
    for meeting in team.meetings:
        x, y = team.middle(meeting)
        axes.plot(x, y, "x", color=style.ALARM, ms=6, mew=1.6)
    handles, _labels = axes.get_legend_handles_labels()
    if team.meetings:
        handles.append(Line2D([], [], ls="", marker="x", color=style.ALARM, label="meeting"))
    axes.legend(handles=handles, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    return figure


def _aspect(team: Team) -> float:
    (x0, y0), (x1, y1) = _corners(team)
    return min(max((y1 - y0) / (x1 - x0), 0.3), 1.1)


def _corners(team: Team) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the lower left and upper right corner of the known part of the map, m."""
    grid = team.folder.map
    known = np.argwhere((grid.cells == FREE) | (grid.cells == OCCUPIED))
    (r0, c0), (r1, c1) = known.min(axis=0), known.max(axis=0) + 1
    x, y = grid.origin.x, grid.origin.y
    res = grid.resolution
    return (x + c0 * res, y + r0 * res), (x + c1 * res, y + r1 * res)


def _draw_map(axes: Axes, team: Team) -> None:
    """Draw walls, free space and border."""
    grid = team.folder.map
    rows, cols = np.nonzero(grid.cells == OCCUPIED)
    res = grid.resolution
    shade = np.full((*grid.cells.shape, 4), 0.0)
    shade[grid.cells == FREE] = (0.965, 0.973, 0.98, 1.0)
    shade[rows, cols] = (0.23, 0.28, 0.33, 1.0)
    x, y = grid.origin.x, grid.origin.y
    height, width = grid.cells.shape
    axes.imshow(
        shade,
        origin="lower",
        extent=(x, x + width * res, y, y + height * res),
        interpolation="nearest",
    )
    if team.folder.border is not None:
        line = team.folder.border.polyline(0.1)
        axes.plot(*line.T, color="#9fb3c8", lw=4, alpha=0.55, label="border", zorder=1)
    for zone in team.zones:
        _draw_zone(axes, zone)
    (x0, y0), (x1, y1) = _corners(team)
    axes.set(xlim=(x0, x1), ylim=(y0, y1), xlabel="x (m)", ylabel="y (m)", aspect="equal")


def _draw_zone(axes: Axes, zone: Zone) -> None:
    """Draw a zone's outline, and its name in its upper left corner."""
    axes.add_patch(Polygon(zone.polygon, fill=False, ec=style.ZONE, lw=0.7, ls=(0, (1, 2))))
    left, top = min(x for x, _ in zone.polygon), max(y for _, y in zone.polygon)
    axes.annotate(
        zone.name,
        (left, top),
        xytext=(3, -3),
        textcoords="offset points",
        va="top",
        color=style.ZONE,
        fontsize=7.5,
        parse_math=False,
        clip_on=True,
    )


def places(team: Team) -> Figure | None:
    """Draw each robot's abscissa along the border over time; None without a border."""
    border = team.folder.border
    if border is None:
        return None
    colors = style.robot_colors(team.names)
    figure = style.new_figure(3.0)
    axes = figure.subplots()
    for run in team.runs:
        s = np.where(run.distance < _ON_BORDER, run.abscissa, np.nan)
        t = run.decision_t + run.shift
        wraps = np.flatnonzero(np.abs(np.diff(s)) > border.length / 2.0) + 1
        t, s = np.insert(t, wraps, t[wraps]), np.insert(s, wraps, np.nan)
        step = max(1, t.size // 6000)
        kept = np.zeros(t.size, bool)
        kept[::step] = True
        kept |= np.isnan(s)
        axes.plot(t[kept], s[kept], color=colors[run.name], lw=1.4, label=run.name)
    for meeting in team.meetings:
        at = border.project(*team.middle(meeting)).abscissa
        axes.plot(meeting.t, at, "o", ms=7, mfc="none", mec=style.ALARM, mew=1.3)
    axes.set(ylim=(0.0, border.length), ylabel="s (m)")
    axes.grid(axis="y")
    style.time_axis(axes, 0.0, team.end)
    handles, labels = axes.get_legend_handles_labels()
    unique = dict(zip(labels, handles, strict=True))
    figure.legend(unique.values(), unique.keys(), loc="outside upper left", ncols=6)
    return figure


def border_distance(team: Team) -> Figure:
    """Draw each robot's distance from the border over time, logarithmic beyond _FLAT."""
    colors = style.robot_colors(team.names)
    figure, panels = style.rows(len(team.runs), 1.45)
    for axes, run in zip(panels, team.runs, strict=True):
        t, distance = style.with_breaks(run.decision_t + run.shift, run.distance, 1.0)
        axes.plot(*style.thinned(t, distance), color=colors[run.name], lw=1.1)
        axes.axhline(0.05, color=style.ALARM, lw=0.8, ls=(0, (4, 3)))
        axes.set_yscale("symlog", linthresh=_FLAT, linscale=1.6)
        axes.set_yticks([0.0, 0.05, 0.1, 1.0, 10.0], ["0", "0.05", "0.1", "1", "10"])
        axes.set_ylim(0.0, max(1.0, float(np.nanmax(run.distance, initial=0.0)) * 1.2))
        axes.grid(axis="y")
        axes.set_ylabel("m")
        axes.set_title(run.name)
        style.time_axis(axes, 0.0, team.end)
    return figure


def action_selection(team: Team) -> Figure:
    """Draw each robot's selected action over time."""
    figure = style.new_figure(0.75 + 0.42 * len(team.names))
    axes = figure.subplots()
    for row, run in enumerate(team.sampled):
        for action, spans in _spans(run).items():
            axes.broken_barh(spans, (row - 0.38, 0.76), color=style.ACTIONS.get(action), lw=0)
    axes.set_yticks(range(len(team.names)), team.names)
    axes.invert_yaxis()
    axes.spines["left"].set_visible(False)
    axes.tick_params(axis="y", length=0)
    style.time_axis(axes, 0.0, team.end)
    _action_legend(figure)
    return figure


def _spans(run: RobotRun) -> dict[str, list[tuple[float, float]]]:
    """Return (start, duration), s, of each period of an action, by action."""
    step = run.t[1] - run.t[0] if run.t.size > 1 else 0.1
    found: dict[str, list[tuple[float, float]]] = {}
    for action, group in groupby(zip(run.t.tolist(), run.action, strict=True), lambda p: p[1]):
        times = [t for t, _ in group]
        if action:
            found.setdefault(action, []).append((times[0], times[-1] - times[0] + step))
    return found


def _action_legend(figure: Figure, seen: Collection[str] = tuple(style.ACTIONS)) -> None:
    handles = [
        Patch(color=color, label=style.words(name))
        for name, color in style.ACTIONS.items()
        if name in seen
    ]
    figure.legend(
        handles=handles, loc="outside upper left", ncols=len(handles), handlelength=1.0, fontsize=9
    )


def action_shares(team: Team) -> Figure:
    """Draw each robot's share of time in each action."""
    figure = style.new_figure(0.7 + 0.4 * len(team.names))
    axes = figure.subplots()
    for row, run in enumerate(team.sampled):
        left = 0.0
        for action, share in action_share([run]).items():
            axes.barh(row, share, left=left, height=0.66, color=style.ACTIONS[action])
            if share > 0.03:
                axes.text(
                    *(left + share / 2, row, f"{100 * share:.0f} %"),
                    ha="center",
                    va="center",
                    color="white",
                    fontsize=8.5,
                )
            left += share
    axes.set_yticks(range(len(team.names)), team.names)
    axes.invert_yaxis()
    axes.set_xlim(0.0, 1.0)
    axes.set_xticks([])
    axes.spines[["left", "bottom"]].set_visible(False)
    axes.tick_params(axis="y", length=0)
    _action_legend(figure)
    return figure


def meeting_close_ups(team: Team) -> Figure | None:
    """Draw the robots' paths through up to SHOWN_MEETINGS meetings; None if there was none."""
    chosen = _distinct_closest(team.meetings)
    if not chosen:
        return None
    figure = style.new_figure(4.5)
    panels = figure.subplots(1, SHOWN_MEETINGS, squeeze=False)[0]
    for axes in panels[len(chosen) :]:
        axes.set_visible(False)
    for axes, meeting in zip(panels, sorted(chosen, key=lambda m: m.t), strict=False):
        _close_up(axes, team, meeting)
    _action_legend(figure)
    return figure


def _distinct_closest(meetings: Sequence[Meeting]) -> list[Meeting]:
    """Return the closest meetings, those of different pairs and outcomes first."""
    closest = sorted(meetings, key=lambda meeting: meeting.closest_m)
    firsts = {(m.robots, m.outcome): m for m in reversed(closest)}.values()
    rest = [meeting for meeting in closest if meeting not in firsts]
    return [*sorted(firsts, key=lambda meeting: meeting.closest_m), *rest][:SHOWN_MEETINGS]


def _close_up(axes: Axes, team: Team, meeting: Meeting) -> None:
    """Draw one meeting: a dot each 0.5 s in the action's color, a line at the closest approach."""
    colors = style.robot_colors(team.names)
    a, b = team.pair(meeting)
    closest = team.closest(meeting)
    pair = np.array([a.position[closest], b.position[closest]])
    x, y = pair.mean(axis=0)
    inside = slice(max(0, closest - int(AROUND_S * 10)), closest + int(AROUND_S * 10) + 1)
    if team.folder.border is not None:
        axes.plot(*team.folder.border.polyline(0.1).T, color="#9fb3c8", lw=5, alpha=0.55, zorder=1)
    for run in (a, b):
        way = run.position[inside]
        axes.plot(*way.T, color=colors[run.name], lw=1.6, zorder=2)
        for point, action in zip(way[::5], run.action[inside][::5], strict=True):
            axes.plot(*point, "o", ms=4.5, color=style.ACTIONS.get(action, style.QUIET), zorder=3)
        shown = way[(np.abs(way - [x, y]) < _VIEW_M - 0.3).all(axis=1)]
        if shown.size:
            axes.annotate(
                run.name,
                shown[0],
                xytext=(5, 5),
                textcoords="offset points",
                color=colors[run.name],
                weight="bold",
                ha="left" if shown[0][0] < x else "right",
            )
    axes.plot(*pair.T, color=style.INK, lw=1.0, ls=(0, (2, 2)), zorder=2)
    axes.set(xlim=(x - _VIEW_M, x + _VIEW_M), ylim=(y - _VIEW_M, y + _VIEW_M), aspect="equal")
    axes.set_title(f"{style.clock(meeting.t)}, closest {meeting.closest_m:.2f} m")
    axes.grid()
    axes.tick_params(length=0, labelsize=8)


def idleness(team: Team) -> Figure | None:
    """Draw worst and mean idleness along the border; None without border or visits."""
    visits = team.visits
    if visits is None or team.folder.border is None:
        return None
    passing = visits.passing
    worst = np.array([longest_of(place, passing) for place in visits.places])
    mean = np.array([mean_of(place, passing) for place in visits.places])
    s = np.linspace(0.0, team.folder.border.length, worst.size)
    figure = style.new_figure(2.3)
    axes = figure.subplots()
    axes.fill_between(s, worst, color="#f0d3d6", lw=0, label="longest wait")
    axes.plot(s, worst, color=style.ALARM, lw=1.0)
    axes.fill_between(s, mean, color="#c7d9ee", lw=0, label="mean wait")
    axes.plot(s, mean, color="#3f7fce", lw=1.3)
    axes.set(xlim=(0.0, s[-1]), ylim=(0.0, None), xlabel="place along the border s (m)", ylabel="s")
    axes.grid()
    figure.legend(loc="outside upper left", ncols=2)
    return figure

"""Figures of the machines: localization, gate, battery, lines, process."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from localization.health import Health
from tools.report import style
from tools.report.incidents import GOOD_STATES, gate_holds, gate_times
from tools.report.run_log import Floats, RunLog
from tools.report.team import Team

_GATE_COLORS = ("#c8323f", "#e9a23b", "#3f7fce", "#8557a8", "#4d9a8a", "#a3742c", "#66727f")
WINDOW_S = 10.0
"""Length of the windows in which packet rates are counted."""


def localization(team: Team) -> Figure:
    """Draw each robot's localization: 95 % bound of the position, true error if known, health."""
    colors = style.robot_colors(team.names)
    figure, panels = style.rows(len(team.runs), 1.3)
    for axes, run in zip(panels, team.runs, strict=True):
        t = run.status_t + run.shift
        axes.plot(*style.thinned(t, run.bounds()), color=colors[run.name], label="95 % bound")
        error_t, error = run.reference_errors()
        if error.size:
            axes.plot(error_t + run.shift, error, ".", ms=3, color=style.INK, label="true error")
        for health, color in ((Health.UNSURE, "#fbe8c8"), (Health.LOST, "#f3c9cd")):
            for start, end in _health_spans(run, health):
                axes.axvspan(start, end, color=color, lw=0)
        axes.set_ylim(0.0, _top(run.bounds(), error))
        axes.set_ylabel("m")
        axes.set_title(run.name)
        axes.grid(axis="y")
        style.time_axis(axes, 0.0, team.end)
    handles, _ = panels[0].get_legend_handles_labels()
    handles += [Patch(color="#fbe8c8", label="unsure"), Patch(color="#f3c9cd", label="lost")]
    figure.legend(handles=handles, loc="outside upper left", ncols=4)
    return figure


def _top(bounds: Floats, errors: Floats) -> float:
    """Return an axis limit, m, by the 99th percentile: outliers are cut off."""
    seen = np.concatenate((bounds[np.isfinite(bounds)], errors))
    return max(0.1, float(np.percentile(seen, 99)) * 1.4) if seen.size else 1.0


def _health_spans(run: RunLog, health: Health) -> list[tuple[float, float]]:
    """Return start and end, team time, s, of each period of a health of the localization."""
    changes = [line for line in run.lines if line.part == "localization"]
    ends = [*(line.t for line in changes[1:]), run.end]
    return [
        (line.t + run.shift, end + run.shift)
        for line, end in zip(changes, ends, strict=False)
        if line.message == health
    ]


def gate(team: Team) -> Figure | None:
    """Draw when the gate held a robot, by reason; None if it never did."""
    holds = {run.path: gate_holds(run) for run in team.runs}
    reasons = sorted({span.what for spans in holds.values() for span in spans})
    if not reasons:
        return None
    colors = dict(zip(reasons, _GATE_COLORS * 3, strict=False))
    figure = style.new_figure(0.75 + 0.42 * len(team.names))
    axes = figure.subplots()
    for run in team.runs:
        for span in holds[run.path]:
            # A short hold must be visible on an axis of an hour.
            width = max(span.end - span.start, team.end / 400)
            axes.broken_barh(
                [(span.start + run.shift, width)],
                (team.names.index(run.name) - 0.38, 0.76),
                color=colors[span.what],
                lw=0,
            )
    axes.set_yticks(range(len(team.names)), team.names)
    axes.set_ylim(len(team.names) - 0.5, -0.5)
    axes.spines["left"].set_visible(False)
    axes.tick_params(axis="y", length=0)
    style.time_axis(axes, 0.0, team.end)
    handles = [Patch(color=colors[reason], label=style.words(reason)) for reason in reasons]
    figure.legend(handles=handles, loc="outside upper left", ncols=6, handlelength=1.0)
    return figure


def gate_table(team: Team) -> list[tuple[str, str, int, float]]:
    """Return robot, reason, count and duration, s, of each reason of the gate."""
    return [
        (run.name, reason, count, seconds)
        for run in team.runs
        for reason, (count, seconds) in sorted(gate_times(run).items(), key=lambda i: -i[1][1])
    ]


def machines(team: Team) -> Figure:
    """Draw battery, packet rates, load and lateness of all robots, one row each."""
    has_process = any(run.process for run in team.runs)
    figure, panels = style.rows(5 if has_process else 3, 1.25)
    _battery(panels[0], team)
    _reports(panels[1], team)
    _bad_packets(panels[2], team)
    if has_process:
        _load(panels[3], team)
        _lateness(panels[4], team)
    for axes in panels:
        axes.grid(axis="y")
        style.time_axis(axes, 0.0, team.end)
    handles, labels = panels[0].get_legend_handles_labels()
    unique = dict(zip(labels, handles, strict=True))
    figure.legend(unique.values(), unique.keys(), loc="outside upper left", ncols=6)
    return figure


def _battery(axes: Axes, team: Team) -> None:
    colors = style.robot_colors(team.names)
    for run in team.runs:
        volts = np.array([np.nan if s.battery is None else s.battery for s in run.status])
        line = style.thinned(run.status_t + run.shift, volts)
        axes.plot(*line, color=colors[run.name], label=run.name)
    axes.axhline(11.5, color=style.ALARM, lw=0.8, ls=(0, (4, 3)))
    axes.set_title("battery (V)")


def _reports(axes: Axes, team: Team) -> None:
    """Draw good packets per second: base solid, laser dashed."""
    colors = style.robot_colors(team.names)
    for run in team.runs:
        for link, dash in zip(GOOD_STATES, ("-", (0, (3, 2))), strict=True):
            good = np.array([getattr(status, link).packets_good for status in run.status])
            t, rate = _rate(run.status_t, good)
            axes.plot(t + run.shift, rate, ls=dash, lw=1.0, color=colors[run.name])
    axes.set_ylim(0.0, None)
    axes.set_title("good packets per second (base solid, laser dashed)")


def _bad_packets(axes: Axes, team: Team) -> None:
    colors = style.robot_colors(team.names)
    for run in team.runs:
        bad = np.array([s.base.packets_bad + s.laser.packets_bad for s in run.status])
        t, rate = _rate(run.status_t, bad)
        axes.plot(t + run.shift, rate, color=colors[run.name], lw=1.0)
    axes.set_ylim(0.0, max(1.0, axes.get_ylim()[1]))
    axes.set_title("damaged packets per second, both lines")


def _rate(t: Floats, count: Floats) -> tuple[Floats, Floats]:
    """Return the middles of windows, s, and the rates of a counter in them, 1/s."""
    if t.size < 2:
        return np.empty(0), np.empty(0)
    edges = np.append(np.arange(t[0], t[-1], WINDOW_S), t[-1])
    at_edges = np.interp(edges, t, count)
    widths = np.diff(edges)
    whole = widths > 0.2 * WINDOW_S
    middles = (edges[:-1] + widths / 2.0)[whole]
    return middles, (np.diff(at_edges)[whole] / widths[whole]).clip(0.0)


def _load(axes: Axes, team: Team) -> None:
    colors = style.robot_colors(team.names)
    for run in team.runs:
        cpu = np.array([100.0 * report.cpu for report in run.process])
        axes.plot(*style.thinned(run.process_t + run.shift, cpu, 800), color=colors[run.name], lw=1)
    axes.axhline(15.0, color=style.ALARM, lw=0.8, ls=(0, (4, 3)))
    axes.set_ylim(0.0, None)
    axes.set_title("agent process, % of a core")


def _lateness(axes: Axes, team: Team) -> None:
    colors = style.robot_colors(team.names)
    for run in team.runs:
        late = np.array([1e3 * report.lateness_max for report in run.process])
        axes.plot(
            *style.thinned(run.process_t + run.shift, late, 800), color=colors[run.name], lw=1
        )
    axes.axhline(50.0, color=style.ALARM, lw=0.8, ls=(0, (4, 3)))
    axes.set_yscale("log")
    axes.set_title("loop jitter: latest event of each second, ms after it came")

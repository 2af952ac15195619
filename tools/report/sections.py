"""The sections of a report: their figures, tables and texts."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from matplotlib import figure as mpl_figure

from robot_agent.messages.log_level import LogLevel
from robot_agent.report.notices import TURN_WORDS
from tools.metrics.metrics import Meeting
from tools.report import machine_figures, patrol_figures, style
from tools.report.blocks import Block, Figure, Folded, Paragraph, Table, row, table
from tools.report.numbers import process_numbers
from tools.report.run_log import LogLine
from tools.report.team import Team

Blocks = Iterator[Block]

SHOWN_EVENTS = 400
_LEVELS = {1: "debug", 2: "info", 3: "warning", 4: "error", 5: "fatal"}


def _drawn(drawn: mpl_figure.Figure | None, caption: str) -> Blocks:
    """Yield a figure; nothing for None."""
    if drawn is not None:
        yield Figure(drawn, caption)


def _incidents(team: Team, _figures: dict[str, Any]) -> Blocks:
    if not team.incidents:
        yield Paragraph("No incident found in the recordings.", "good")
        return
    rows = [
        (
            style.clock(incident.start),
            f"{incident.end - incident.start:.1f}",
            incident.robot,
            team.words.placed(incident.what, team.place(incident.robot, incident.start)),
            incident.reaction,
        )
        for incident in team.incidents
    ]
    yield table(("at", "lasted (s)", "robot", "what", "reaction"), rows)


def _overview(team: Team, _figures: dict[str, Any]) -> Blocks:
    yield from _drawn(
        patrol_figures.trajectories(team),
        "The robots' paths by their own poses; a dot is a start, a cross a meeting.",
    )
    yield from _drawn(
        patrol_figures.places(team),
        "Place along the border over time; a dot is a meeting. Where two lines touch, two robots "
        "met; a gap between all lines is a stretch without a visit.",
    )


def _patrol(team: Team, figures: dict[str, Any]) -> Blocks:
    if team.folder.border is None:
        return
    rows = [
        (
            robot["robot"],
            "never" if robot["reach_s"] is None else f"{robot['reach_s']:.1f}",
            *(_number(robot["border_distance_m"][key]) for key in ("median", "p95", "p99", "max")),
        )
        for robot in figures["robots"]
    ]
    heads = ("robot", "reached border (s)", "median (m)", "p95 (m)", "p99 (m)", "max (m)")
    caption = "Distance from the border by the robot's own pose; dashed: 0.05 m."
    yield from _drawn(patrol_figures.border_distance(team), caption)
    yield table(heads, rows)


def _number(value: float | None, form: str = "{:.3f}") -> str:
    return "–" if value is None else form.format(value)


def _actions(team: Team, figures: dict[str, Any]) -> Blocks:
    yield from _drawn(
        patrol_figures.action_selection(team), "The action each robot had selected, over time."
    )
    yield from _drawn(patrol_figures.action_shares(team), "Share of the time per action.")
    turns = [
        (robot["robot"], TURN_WORDS.get(cause, cause), str(count))
        for robot in figures["robots"]
        for cause, count in robot["turns"].items()
    ]
    if turns:
        yield table(("robot", "turned back", "times"), turns)
    overrides = [
        (robot["robot"], style.words(reason), str(sums["times"]), f"{sums['seconds']:.1f}")
        for robot in figures["robots"]
        for reason, sums in robot["overrides"].items()
    ]
    if overrides:
        yield table(("robot", "beyond the rules", "times", "for (s)"), overrides)


def _meetings(team: Team, _figures: dict[str, Any]) -> Blocks:
    if not team.meetings:
        return
    rows = [
        (
            style.clock(meeting.t),
            _meeting_place(team, meeting),
            " and ".join(meeting.robots),
            " / ".join(map(style.words, meeting.actions)),
            f"{meeting.closest_m:.2f}",
            meeting.outcome,
        )
        for meeting in team.meetings
    ]
    yield from _drawn(
        patrol_figures.meeting_close_ups(team),
        "The closest meetings, 6 s before and after: a dot each half second, in the color of the "
        "action; dashed: the closest approach; axes in m.",
    )
    heads = ("at", "where", "robots", "what each did", "closest (m)", "ended")
    yield Folded(f"all {len(rows)} meetings", table(heads, rows), len(rows) <= 12)


def _meeting_place(team: Team, meeting: Meeting) -> str:
    """Return a meeting's place along the border, in words; empty without a border."""
    border = team.folder.border
    if border is None:
        return ""
    s = border.project(*team.middle(meeting)).abscissa
    return team.words.explained(f"s = {s:.1f} m")


def _idleness(team: Team, figures: dict[str, Any]) -> Blocks:
    figure = patrol_figures.idleness(team)
    if figure is None:
        return
    idle = figures["idleness_s"]
    words = (
        f"Average over the border {_number(idle['average'], '{:.1f}')} s, worst mean "
        f"{_number(idle['worst_average'], '{:.1f}')} s, longest wait "
        f"{_number(idle['worst'], '{:.1f}')} s; counted from when the last robot had arrived."
    )
    yield Figure(figure, f"Time between visits at each place. {words}")


def _gate(team: Team, _figures: dict[str, Any]) -> Blocks:
    rows = [
        (robot, style.words(reason), str(count), f"{seconds:.1f}")
        for robot, reason, count, seconds in machine_figures.gate_table(team)
    ]
    if not rows:
        return
    caption = "Holds of the safety gate by reason; short ones are drawn wider than they were."
    heads = ("robot", "reason", "times", "together (s)")
    yield from _drawn(machine_figures.gate(team), caption)
    yield table(heads, rows)


def _localization(team: Team, figures: dict[str, Any]) -> Blocks:
    rows = [
        (
            robot["robot"],
            *(_number(robot["localization"]["bound_m"][key]) for key in ("median", "p95", "max")),
            *(_number(robot["localization"]["error_m"][key]) for key in ("median", "p95", "max")),
            f"{100 * robot['localization']['health_share'].get('localized', 0.0):.1f} %",
        )
        for robot in figures["robots"]
    ]
    heads = (
        "robot",
        "bound: median (m)",
        "p95",
        "max",
        "error: median (m)",
        "p95",
        "max",
        "localized",
    )
    caption = (
        "Semi-major axis of the position's 95 % ellipse, by the filter's covariance; dots: "
        "distance from the true position, where recorded."
    )
    yield from _drawn(machine_figures.localization(team), caption)
    yield table(heads, rows)


def _machines(team: Team, figures: dict[str, Any]) -> Blocks:
    caption = "Dashed red: 11.5 V, 15 % of a core, 50 ms."
    rows = []
    for run, robot in zip(team.runs, figures["robots"], strict=True):
        process = process_numbers(run)
        lines = robot["lines"]
        rows.append(
            (
                run.name,
                _number(robot["battery_v"]["first"], "{:.1f}"),
                _number(robot["battery_v"]["last"], "{:.1f}"),
                *(str(lines[link]["packets_bad"]) if lines else "–" for link in ("base", "laser")),
                *(lines[link]["happened"] or "–" if lines else "–" for link in ("base", "laser")),
                *(
                    _number(None if process is None else scale * process[key], form)
                    for key, scale, form in (
                        ("cpu_mean", 100.0, "{:.1f}"),
                        ("memory_mb", 1.0, "{:.0f}"),
                        ("lateness_median_s", 1e3, "{:.2f}"),
                        ("lateness_max_s", 1e3, "{:.0f}"),
                        ("deadline_misses", 1.0, "{:.0f}"),
                    )
                ),
            )
        )
    heads = (
        *("robot", "battery: first (V)", "last (V)", "bad packets: base", "laser"),
        *("sessions: base", "laser"),
        *("load (%)", "memory (MB)", "lateness: median (ms)", "largest (ms)", "deadlines missed"),
    )
    yield from _drawn(machine_figures.machines(team), caption)
    yield table(heads, rows)


def _clocks(team: Team, figures: dict[str, Any]) -> Blocks:
    if len(team.runs) < 2 and not team.runs[0].truncated:
        yield _versions(figures)
        return
    rows = [
        (
            run.path.name,
            run.name,
            f"{run.shift:.3f}",
            f"{clock.correction:+.3f}",
            clock.how,
            _number(clock.residual),
            run.readable_part,
        )
        for run, clock in zip(team.runs, team.clocks, strict=True)
    ]
    heads = (
        "recording",
        "robot",
        "starts at (s)",
        "clock moved (s)",
        "how",
        "residual (m)",
        "file",
    )
    yield table(heads, rows)
    yield _versions(figures)


def _versions(figures: dict[str, Any]) -> Paragraph:
    robot = figures["robots"][0]
    place = figures["map"]
    return Paragraph(
        f"Map {place['hash'][:12]}, border {place['border_hash'][:12]}; seeds "
        f"{', '.join(str(robot['seed']) for robot in figures['robots'])}; "
        f"{robot['versions'] or 'versions not recorded'}.",
        "small",
    )


def _events(team: Team, _figures: dict[str, Any]) -> Blocks:
    lines = sorted(
        ((line.t + run.shift, run.name, line) for run in team.runs for line in run.lines),
        key=lambda entry: entry[0],
    )
    rows = [
        row(
            (
                style.clock(t),
                name,
                _LEVELS.get(line.level, ""),
                line.part,
                _told(team, t, name, line),
            ),
            f"level{line.level}",
        )
        for t, name, line in lines[:SHOWN_EVENTS]
    ]
    more = f", the first {SHOWN_EVENTS} of them" if len(lines) > SHOWN_EVENTS else ""
    events = Table(("at", "robot", "level", "part", "what"), rows)
    yield Folded(f"{len(lines)} events{more}", events, len(lines) <= 25)


def _told(team: Team, t: float, robot: str, line: LogLine) -> str:
    """Return an event's text with its places' zones; a warning without any: its robot's zone."""
    place = team.place(robot, t) if line.level >= LogLevel.WARNING else None
    return team.words.placed(line.message, place)


Section = tuple[str, str, Callable[[Team, dict[str, Any]], Blocks]]
"""Anchor, title, and the function that yields the blocks from a team and its numbers."""
SECTIONS: tuple[Section, ...] = (
    ("incidents", "Incidents and reactions", _incidents),
    ("map", "Where they went", _overview),
    ("border", "Distance from the border", _patrol),
    ("actions", "Action selection", _actions),
    ("meetings", "Meetings", _meetings),
    ("idleness", "Idleness along the border", _idleness),
    ("localization", "Localization", _localization),
    ("gate", "Safety gate", _gate),
    ("machines", "Battery, lines, process", _machines),
    ("clocks", "Recordings and clocks", _clocks),
    ("events", "Events", _events),
)

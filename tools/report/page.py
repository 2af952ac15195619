"""The report as one HTML page that needs nothing beside it."""

from __future__ import annotations

import datetime
from collections.abc import Callable, Iterable, Sequence
from html import escape
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure

from tools.report import machine_figures, patrol_figures, style
from tools.report.numbers import process_numbers
from tools.report.team import Team

SHOWN_EVENTS = 400
_LEVELS = {1: "debug", 2: "info", 3: "warning", 4: "error", 5: "fatal"}


def page(team: Team, figures: dict[str, Any], progress: Callable[[float], None]) -> str:
    """Return the page; ``figures`` are the report's numbers, ``progress`` hears the sections."""
    with mpl.rc_context(style.RC):
        sections = []
        for done, (anchor, title, build) in enumerate(_SECTIONS):
            body = build(team, figures)
            progress(done + 1)
            if body:
                sections.append((anchor, title, body))
    style_sheet = (Path(__file__).parent / "page.css").read_text()
    links = "".join(f'<a href="#{anchor}">{escape(title)}</a>' for anchor, title, _ in sections)
    body = "".join(
        f'<section id="{anchor}"><h2>{escape(title)}</h2>{content}</section>'
        for anchor, title, content in sections
    )
    title = f"{', '.join(team.names)} on {team.folder.name}"
    return (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title>'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<style>{style_sheet}</style></head><body>"
        f"<header><h1>{escape(title)}</h1><p>{_subtitle(team)}</p>{_tiles(figures)}"
        f"<nav>{links}</nav></header><main>{body}</main></body></html>\n"
    )


def _subtitle(team: Team) -> str:
    header = team.runs[0].header
    start = datetime.datetime.fromtimestamp(header.start_wall_ns / 1e9, datetime.UTC)
    border = team.folder.border
    parts = [
        f"{len(team.runs)} recording{'s' if len(team.runs) > 1 else ''}",
        f"{style.clock(team.end)} min",
        "no border" if border is None else f"border of {border.length:.1f} m",
        f"software {header.software_version}",
        f"source: {header.source}",
    ]
    if header.start_wall_ns > 1e18:
        parts.insert(0, start.strftime("%Y-%m-%d %H:%M UTC"))
    return escape(" · ".join(parts))


# --- headline ---------------------------------------------------------------------------------


def _tiles(figures: dict[str, Any]) -> str:
    """Return the few numbers that say whether the run was good."""
    robots = figures["robots"]
    p99 = _largest(robot["border_distance_m"]["p99"] for robot in robots)
    reach = [robot["reach_s"] for robot in robots if robot["reach_s"] is not None]
    idle = figures["idleness_s"]
    shares = [robot["localization"]["health_share"].get("localized", 0.0) for robot in robots]
    processes = [robot["process"] for robot in robots if robot["process"]]
    stops = len(figures["incidents"])
    tiles = [
        _tile("distance from border, p99", p99, "{:.3f} m", worse=p99 is not None and p99 > 0.05),
        _tile("on the border after", max(reach) if reach else None, "{:.0f} s"),
        _tile("meetings", len(figures["meetings"]), "{:d}"),
        _tile("closest approach", figures["closest_m"], "{:.2f} m"),
        _tile("longest wait of a place", idle["worst"], "{:.0f} s"),
        _tile("localized", 100.0 * min(shares), "{:.1f} %", worse=min(shares) < 0.98),
        _tile("incidents", stops, "{:d}", worse=stops > 0),
    ]
    if processes:
        load = 100.0 * max(process["cpu_mean"] for process in processes)
        misses = sum(process["deadline_misses"] for process in processes)
        tiles.append(_tile("agent's load", load, "{:.1f} %", worse=load > 15.0))
        tiles.append(_tile("deadlines missed", misses, "{:d}", worse=misses > 0))
    return f'<div class="tiles">{"".join(tiles)}</div>'


def _largest(values: Iterable[float | None]) -> float | None:
    return max((value for value in values if value is not None), default=None)


def _tile(label: str, value: float | None, form: str, *, worse: bool = False) -> str:
    text = "–" if value is None else form.format(value)
    return (
        f'<div class="tile{" worse" if worse else ""}"><b>{text}</b>'
        f"<span>{escape(label)}</span></div>"
    )


# --- sections ---------------------------------------------------------------------------------


def _figure(figure: Figure | None, caption: str) -> str:
    if figure is None:
        return ""
    drawing = style.svg(figure, caption)
    return f"<figure>{drawing}<figcaption>{escape(caption)}</figcaption></figure>"


def _table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table; a cell that begins with a digit or minus is set as a number."""
    head = "".join(f"<th>{escape(text)}</th>" for text in heads)
    body = "".join(f"<tr>{''.join(map(_cell, row))}</tr>" for row in rows)
    return f"<div class='table'><table><tr>{head}</tr>{body}</table></div>"


def _cell(text: str) -> str:
    number = text[:1].isdigit() or text[:1] == "-"
    return f"<td{' class=number' if number else ''}>{escape(text)}</td>"


def _incidents(team: Team, _figures: dict[str, Any]) -> str:
    if not team.incidents:
        return "<p class='good'>Nothing went wrong that a recording can show.</p>"
    rows = [
        (
            style.clock(incident.start),
            f"{incident.end - incident.start:.1f}",
            incident.robot,
            incident.what,
            incident.reaction,
        )
        for incident in team.incidents
    ]
    return _table(("at", "lasted (s)", "robot", "what", "reaction"), rows)


def _overview(team: Team, _figures: dict[str, Any]) -> str:
    return _figure(
        patrol_figures.trajectories(team),
        "Where the robots went, by their own poses; a dot is a start, a cross a meeting.",
    ) + _figure(
        patrol_figures.places(team),
        "Place along the border over time; a dot is a meeting. Where two lines touch, two robots "
        "met; a gap between all lines is a stretch that waited.",
    )


def _patrol(team: Team, figures: dict[str, Any]) -> str:
    if team.folder.border is None:
        return ""
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
    return _figure(patrol_figures.border_distance(team), caption) + _table(heads, rows)


def _number(value: float | None, form: str = "{:.3f}") -> str:
    return "–" if value is None else form.format(value)


def _actions(team: Team, _figures: dict[str, Any]) -> str:
    selection = _figure(
        patrol_figures.action_selection(team), "The action each robot had selected, over time."
    )
    return selection + _figure(patrol_figures.action_shares(team), "Share of the time per action.")


def _meetings(team: Team, _figures: dict[str, Any]) -> str:
    if not team.meetings:
        return ""
    rows = [
        (
            style.clock(meeting.t),
            " and ".join(meeting.robots),
            " / ".join(map(style.words, meeting.actions)),
            f"{meeting.closest_m:.2f}",
            meeting.outcome,
        )
        for meeting in team.meetings
    ]
    pictures = _figure(
        patrol_figures.meeting_close_ups(team),
        "The closest meetings, 6 s before and after: a dot each half second, in the color of the "
        "action; dashed: the closest approach; axes in m.",
    )
    heads = ("at", "robots", "what each did", "closest (m)", "ended")
    return pictures + _folded(f"all {len(rows)} meetings", _table(heads, rows), len(rows) <= 12)


def _folded(title: str, content: str, is_open: bool) -> str:
    return f"<details{' open' if is_open else ''}><summary>{title}</summary>{content}</details>"


def _idleness(team: Team, figures: dict[str, Any]) -> str:
    figure = patrol_figures.idleness(team)
    if figure is None:
        return ""
    idle = figures["idleness_s"]
    words = (
        f"Average over the border {_number(idle['average'], '{:.1f}')} s, worst mean "
        f"{_number(idle['worst_average'], '{:.1f}')} s, longest wait "
        f"{_number(idle['worst'], '{:.1f}')} s; counted from when the last robot had arrived."
    )
    return _figure(figure, f"How long each place waited for a robot. {words}")


def _gate(team: Team, _figures: dict[str, Any]) -> str:
    rows = [
        (robot, style.words(reason), str(count), f"{seconds:.1f}")
        for robot, reason, count, seconds in machine_figures.gate_table(team)
    ]
    if not rows:
        return ""
    caption = "When the safety gate held a robot, and why; moments are drawn wider than they were."
    heads = ("robot", "reason", "times", "together (s)")
    return _figure(machine_figures.gate(team), caption) + _table(heads, rows)


def _localization(team: Team, figures: dict[str, Any]) -> str:
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
        "Half the longer axis of the ellipse that holds the position with 95 %, by the filter's "
        "own covariance; dots: distance from the true position, where the recording knows it."
    )
    return _figure(machine_figures.localization(team), caption) + _table(heads, rows)


def _machines(team: Team, figures: dict[str, Any]) -> str:
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
        *("load (%)", "memory (MB)", "lateness: median (ms)", "largest (ms)", "deadlines missed"),
    )
    return _figure(machine_figures.machines(team), caption) + _table(heads, rows)


def _clocks(team: Team, figures: dict[str, Any]) -> str:
    if len(team.runs) < 2 and not team.runs[0].truncated:
        return _versions(figures)
    rows = [
        (
            run.path.name,
            run.name,
            f"{run.shift:.3f}",
            f"{clock.correction:+.3f}",
            clock.how,
            _number(clock.residual),
            run.truncated or "whole",
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
    return _table(heads, rows) + _versions(figures)


def _versions(figures: dict[str, Any]) -> str:
    robot = figures["robots"][0]
    place = figures["map"]
    return (
        f"<p class='small'>Map {escape(place['hash'][:12])}, border "
        f"{escape(place['border_hash'][:12])}; seeds "
        f"{', '.join(str(robot['seed']) for robot in figures['robots'])}; "
        f"{escape(robot['versions'] or 'versions not recorded')}.</p>"
    )


def _events(team: Team, _figures: dict[str, Any]) -> str:
    lines = sorted(
        ((line.t + run.shift, run.name, line) for run in team.runs for line in run.lines),
        key=lambda entry: entry[0],
    )
    rows = "".join(
        f"<tr class='level{line.level}'><td class=number>{style.clock(t)}</td>"
        f"<td>{escape(name)}</td><td>{_LEVELS.get(line.level, '')}</td>"
        f"<td>{escape(line.part)}</td><td>{escape(line.message)}</td></tr>"
        for t, name, line in lines[:SHOWN_EVENTS]
    )
    heads = "<tr><th>at</th><th>robot</th><th>level</th><th>part</th><th>what</th></tr>"
    more = f", the first {SHOWN_EVENTS} of them" if len(lines) > SHOWN_EVENTS else ""
    table = f"<div class='table'><table>{heads}{rows}</table></div>"
    return _folded(f"{len(lines)} events{more}", table, len(lines) <= 25)


Section = tuple[str, str, Callable[[Team, dict[str, Any]], str]]
_SECTIONS: tuple[Section, ...] = (
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
SECTIONS = len(_SECTIONS)

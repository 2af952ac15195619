"""The team as a live table in a terminal, or as plain text for other outputs."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Iterable
from typing import NamedTuple, TextIO

from rich.console import Console, Group
from rich.live import Live
from rich.table import Table
from rich.text import Text

from maps.input_limits import BAD_DATA
from robot_agent.messages.foxglove import planar_pose
from robot_agent.messages.streams import DecisionPayload, StatusPayload
from tools.monitor.alarm_board import Alarm
from tools.monitor.reason import why
from tools.monitor.robot_state import RobotState
from tools.monitor.text_details import detail_lines
from tools.monitor.watch import Watch

REFRESH_S = 0.25
PLAIN_PERIOD_S = 5.0
ABSENT = "-"


class Row(NamedTuple):
    """One robot's row; the field names are the headings."""

    robot: str
    pose: str  # x, y (m), heading (deg)
    action: str
    border: str  # distance from it, m
    teammate: str  # distance of the nearest, m
    battery: str  # V
    base: str
    laser: str
    localization: str
    speed: str  # m/s, rad/s, as sent
    gate: str
    age: str  # s since the last message
    why: str  # what it does and why


def row_of(robot: RobotState, now: float) -> Row:
    """Return one robot's row at the operator's monotonic time now, s."""
    decision, status = robot.decision, robot.status
    row = Row(
        robot=f"{robot.team}/{robot.robot}",
        pose=_pose(robot),
        action=ABSENT if decision is None else _action(decision),
        border=ABSENT if decision is None else f"{decision.distance_from_border:.2f} m",
        teammate=_quantity(None if decision is None else decision.distance_from_neighbor, "m", 2),
        battery=_quantity(None if status is None else status.battery, "V", 1),
        base=ABSENT if status is None else status.base.state,
        laser=ABSENT if status is None else status.laser.state,
        localization=ABSENT if status is None else status.localization.health,
        speed=ABSENT if decision is None else _speed(decision),
        gate=_gate(decision, status),
        age=_age(robot, now),
        why=why(robot, now),
    )
    return Row(*map(_printable, row))


def _shown_row(robot: RobotState, now: float) -> Row:
    """Return one robot's row, empty but for the reason if its telemetry makes none."""
    try:
        return row_of(robot, now)
    except BAD_DATA:
        return Row._make((robot.id, *[ABSENT] * (len(Row._fields) - 2), "cannot be read"))


def _printable(cell: str) -> str:
    """Escape a cell with control characters: they came over the network."""
    return cell if cell.isprintable() else repr(cell)


def _pose(robot: RobotState) -> str:
    if robot.pose is None:
        return ABSENT
    x, y, theta = planar_pose(robot.pose.pose)
    return f"{x:.2f} {y:.2f} {math.degrees(theta):.0f}°"


def _action(decision: DecisionPayload) -> str:
    sense = "cw" if decision.direction > 0 else "ccw"
    return f"{decision.action} ({sense})"


def _speed(decision: DecisionPayload) -> str:
    return f"{decision.command.v:.2f} m/s {decision.command.w:.2f} rad/s"


def _quantity(value: float | None, unit: str, digits: int) -> str:
    return ABSENT if value is None else f"{value:.{digits}f} {unit}"


def _gate(decision: DecisionPayload | None, status: StatusPayload | None) -> str:
    """Return the gate's reason, else the robot's health, else ``ABSENT``."""
    if decision is not None and decision.gate_reason:
        return decision.gate_reason
    if status is not None and status.health != "ok":
        return status.health
    return ABSENT


def _age(robot: RobotState, now: float) -> str:
    age = "never" if robot.last_heard is None else f"{now - robot.last_heard:.1f} s"
    return age if robot.online else f"offline ({age})"


def team_table(team: Iterable[RobotState], now: float) -> Table:
    """Return the table of the team at the operator's monotonic time now, s."""
    table = Table()
    for heading in Row._fields:
        table.add_column(heading)
    for robot in team:
        style = None if robot.online else "dim"
        table.add_row(*map(Text, _shown_row(robot, now)), style=style)
    return table


def plain_table(team: Iterable[RobotState], now: float) -> str:
    """Return the table of the team as lines of text, columns aligned."""
    rows = [Row._fields, *(_shown_row(robot, now) for robot in team)]
    widths = [max(len(row[column]) for row in rows) for column in range(len(Row._fields))]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    )


def plain_alarm(alarm: Alarm, now: float) -> str:
    """Return one alarm as a line of text; now: s on the board's clock."""
    robot = f"{alarm.robot}: " if alarm.robot else ""
    until = "" if alarm.active else ", over"
    words = f"{alarm.severity.name} {robot}{alarm.text} ({now - alarm.raised:.0f} s ago{until})"
    return _printable(words)


def team_view(watch: Watch) -> Group:
    """Return table, alarms and details of a team for a terminal."""
    return Group(team_table(watch.robots, watch.now), *map(Text, _lines_below(watch)))


def plain_view(watch: Watch) -> str:
    """Return table, alarms and details of a team as lines of text."""
    return "\n".join([plain_table(watch.robots, watch.now), *_lines_below(watch)])


def _lines_below(watch: Watch) -> list[str]:
    """Return the active alarms in the board's order, then the details."""
    active = [alarm for alarm in watch.alarms.alarms() if alarm.active]
    details = map(_printable, detail_lines(watch))
    return [*(plain_alarm(alarm, watch.now) for alarm in active), *details]


def show_team(
    watch: Watch,
    going_on: Callable[[], bool],
    *,
    out: TextIO | None = None,
    period: float = PLAIN_PERIOD_S,
) -> None:
    """Show a team until ``going_on`` returns False.

    A terminal gets a live view; any other ``out`` (default: standard output) gets a plain one
    every ``period`` seconds, and one at the end.
    """
    out = sys.stdout if out is None else out
    if out.isatty():
        _show_live(watch, going_on, out)
    else:
        _print_plain(watch, going_on, out, period)


def _show_live(watch: Watch, going_on: Callable[[], bool], out: TextIO) -> None:
    with Live(console=Console(file=out), auto_refresh=False) as live:
        while going_on():
            time.sleep(REFRESH_S)
            live.update(team_view(watch), refresh=True)


def _print_plain(watch: Watch, going_on: Callable[[], bool], out: TextIO, period: float) -> None:
    due = time.monotonic() + period
    while going_on():
        time.sleep(REFRESH_S)
        if time.monotonic() >= due:
            due += period
            print(plain_view(watch), file=out, flush=True)
    print(plain_view(watch), file=out, flush=True)

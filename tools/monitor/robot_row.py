"""The terminal's list of robots: one line a robot, those in trouble first."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from itertools import count
from typing import NamedTuple

from rich.table import Table
from rich.text import Text

from maps.input_limits import BAD_DATA
from tools.monitor.alarm import Severity
from tools.monitor.reason import why
from tools.monitor.robot_state import RobotState
from tools.monitor.watch import Watch

ABSENT = "-"
NAME_WIDTH = 16
WIDE = 100
"""Columns of a terminal from which a row has all its cells."""
HEADINGS = {"mark": "", "number": "#", "s": "s, m", "speed": "m/s"}
WIDE_ONLY = frozenset({"border", "speed", "pose"})
_OWN_NUMBER = re.compile(r"[0-9]{1,3}$")
MARKS = {Severity.CRITICAL: "!!", Severity.WARNING: "!"}
STYLES = {Severity.CRITICAL: "bold red", Severity.WARNING: "yellow"}


class Row(NamedTuple):
    """One robot's cells; the field names are the headings but for those in ``HEADINGS``."""

    mark: str  # of its worst active alarm
    number: str
    robot: str
    battery: str  # V
    heard: str  # time since its last message
    s: str  # along the border, m
    border: str  # distance from it, m
    speed: str  # m/s, as sent
    pose: str  # health of the localization
    doing: str  # what it does and why; the last: it is cut where the line ends


class NumberedRobot(NamedTuple):
    """A robot with its number, as on the page, and its worst active alarm."""

    number: int
    robot: RobotState
    trouble: Severity | None


def numbered_robots(watch: Watch) -> list[NumberedRobot]:
    """Return the team, those in trouble first, the rest by number."""
    trouble: dict[str, Severity] = {}
    for alarm in watch.alarms.alarms():
        if alarm.active:
            trouble[alarm.robot] = max(trouble.get(alarm.robot, Severity.INFO), alarm.severity)
    team = [
        NumberedRobot(number, robot, trouble.get(robot.id))
        for number, robot in _numbers(watch.robots).items()
    ]
    return sorted(team, key=lambda each: (-(each.trouble or 0), each.number))


def _numbers(robots: Iterable[RobotState]) -> dict[int, RobotState]:
    """Return the robots by number: the one that the name ends in, else a free one."""
    numbers: dict[int, RobotState] = {}
    others = []
    for robot in robots:
        own = _OWN_NUMBER.search(robot.id)
        if own and int(own[0]) not in {0, *numbers}:
            numbers[int(own[0])] = robot
        else:
            others.append(robot)
    free = (number for number in count(1) if number not in numbers)
    return numbers | dict(zip(free, others, strict=False))


def row_of(numbered: NumberedRobot, now: float, names: Mapping[str, str]) -> Row:
    """Return one robot's row at the operator's monotonic time now, s.

    names: what robots are called, by id.
    """
    robot = numbered.robot
    decision, status = robot.decision, robot.status
    row = Row(
        mark="" if numbered.trouble is None else MARKS.get(numbered.trouble, ""),
        number=str(numbered.number),
        robot=names[robot.id],
        battery=ABSENT if status is None else f"{status.battery:.1f} V",
        heard=_heard(robot, now),
        s=ABSENT if decision is None else f"{decision.abscissa:.1f}",
        border=ABSENT if decision is None else f"{decision.distance_from_border:.2f} m",
        speed=ABSENT if decision is None else f"{decision.command.v:.2f}",
        pose=ABSENT if status is None else status.localization.health,
        doing=why(robot, now),
    )
    return Row(*map(printable, row))


def shown_row(numbered: NumberedRobot, now: float, names: Mapping[str, str]) -> Row:
    """Return one robot's row, empty but for names and reason if its telemetry makes none."""
    try:
        return row_of(numbered, now, names)
    except BAD_DATA:
        cells = dict.fromkeys(Row._fields, ABSENT)
        named = {"mark": "", "number": str(numbered.number), "robot": names[numbered.robot.id]}
        return Row(**{**cells, **named, "doing": "cannot be read"})


def printable(cell: str) -> str:
    """Escape a cell with control characters: they came over the network."""
    return cell if cell.isprintable() else repr(cell)


def names_of(team: Iterable[RobotState]) -> dict[str, str]:
    """Return the robots' names by id, with the team where there are several."""
    robots = list(team)
    several = len({robot.team for robot in robots}) > 1
    return {robot.id: robot.id if several else robot.robot for robot in robots}


def _heard(robot: RobotState, now: float) -> str:
    if robot.last_heard is None:
        return "never"
    age = max(now - robot.last_heard, 0.0)
    if age < 10.0:
        return f"{age:.1f} s"
    return f"{age:.0f} s" if age < 600.0 else f"{age / 60.0:.0f} min"


def robots_table(
    robots: Iterable[NumberedRobot], watch: Watch, width: int | None, chosen: str | None = None
) -> Table:
    """Return a table with one line a robot.

    width: of the terminal, columns, no line is longer; None: no line is cut. chosen: id of the
    robot to mark.
    """
    names = names_of(watch.robots)
    table = Table(box=None, padding=(0, 1, 0, 0), pad_edge=False, expand=width is not None)
    all_cells = width is None or width >= WIDE
    fields = [name for name in Row._fields[:-1] if all_cells or name not in WIDE_ONLY]
    for name in fields:
        table.add_column(
            HEADINGS.get(name, name),
            no_wrap=True,
            overflow="ellipsis",
            min_width=2 if name == "mark" else None,
            max_width=NAME_WIDTH if name == "robot" else None,
            justify="right" if name in {"number", "battery", "heard", "s"} else "left",
        )
    table.add_column("doing", no_wrap=True, overflow="ellipsis", ratio=1)
    for each in robots:
        row = shown_row(each, watch.now, names)
        style = "" if each.trouble is None else STYLES.get(each.trouble, "")
        cells = [Text(getattr(row, name)) for name in fields]
        marked = f"{style} reverse" if each.robot.id == chosen else style
        table.add_row(*cells, Text(row.doing), style=marked)
    return table

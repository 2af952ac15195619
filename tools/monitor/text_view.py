"""The team in a terminal: alarms, one line a robot, details of one; or as plain text elsewhere."""

from __future__ import annotations

import io
import os
import sys
import time
from collections.abc import Callable, Sequence
from typing import NamedTuple, TextIO

from rich.console import Console, ConsoleDimensions, Group
from rich.layout import Layout
from rich.live import Live
from rich.padding import Padding
from rich.text import Text

from tools.monitor.alarm import Severity
from tools.monitor.alarm_board import Alarm
from tools.monitor.robot_choice import HELP, RobotChoice
from tools.monitor.robot_row import (
    STYLES,
    NumberedRobot,
    numbered_robots,
    printable,
    robots_table,
)
from tools.monitor.text_details import detail_lines, idleness_words
from tools.monitor.view_keys import view_keys
from tools.monitor.watch import Watch

REFRESH_S = 0.25
PLAIN_PERIOD_S = 5.0
ENDLESS = 10_000
"""Width of plain text, columns: nothing is cut."""
DETAILS_LEAST = 5
"""Lines that a long list of robots leaves to the details."""
FRAME = 3
"""Lines of header, headings and footer."""


class Size(NamedTuple):
    """Size of a terminal, characters."""

    width: int
    height: int


class Shares(NamedTuple):
    """Lines of a terminal for alarms and robots; the rest is the details'."""

    alarms: int
    robots: int


def active_alarms(watch: Watch) -> list[Alarm]:
    """Return the active alarms, the worst first."""
    return [alarm for alarm in watch.alarms.alarms() if alarm.active]


def alarm_words(alarm: Alarm, now: float) -> str:
    """Return one active alarm as a line of text; now: s on the board's clock."""
    robot = f"{alarm.robot}: " if alarm.robot else ""
    seen = ", acknowledged" if alarm.acknowledged else ""
    words = f"{alarm.severity.name} {robot}{alarm.text} ({now - alarm.raised:.0f} s ago{seen})"
    return printable(words)


def headline(watch: Watch, alarms: Sequence[Alarm]) -> Text:
    """Return the first line: how many alarms of each severity, how many robots."""
    counts = [(level, sum(alarm.severity == level for alarm in alarms)) for level in Severity]
    told = [f"{count} {level.name.lower()}" for level, count in reversed(counts) if count]
    robots = len(watch.robots)
    state = ", ".join(told) or ("all well" if robots else "no robot has reported yet")
    team = f"{robots} robot{'' if robots == 1 else 's'}"
    words = "; ".join(filter(None, (state, team, idleness_words(watch))))
    return _line(words, STYLES.get(alarms[0].severity, "") if alarms else "green")


def shares_of(height: int, alarms: int, robots: int) -> Shares:
    """Return how many lines alarms and robots get of a terminal; details get what is left."""
    most_alarms = max(3, height // 6)
    shown_alarms = min(alarms, most_alarms)
    room = height - FRAME - shown_alarms - DETAILS_LEAST
    return Shares(shown_alarms, max(1, min(robots, room)))


def team_view(watch: Watch, choice: RobotChoice, size: Size) -> Layout:
    """Return the view of a team that fills a terminal of a size."""
    alarms, robots = active_alarms(watch), numbered_robots(watch)
    shares = shares_of(size.height, len(alarms), len(robots))
    chosen = choice.chosen(robots)
    listed = _window(robots, chosen, shares.robots)
    table = robots_table(listed, watch, size.width, chosen.robot.id if chosen else None)
    parts = [Layout(headline(watch, alarms), size=1)]
    if alarms:
        parts.append(Layout(_alarm_lines(alarms, watch.now, shares.alarms), size=shares.alarms))
    parts += [Layout(table, size=1 + shares.robots), Layout(_details(watch, chosen), ratio=1)]
    beyond = f"{len(robots) - len(listed)} more robots; " if len(listed) < len(robots) else ""
    parts.append(Layout(_line(f"{beyond}{HELP}", "dim"), size=1))
    view = Layout()
    view.split_column(*parts)
    return view


def _window(
    robots: Sequence[NumberedRobot], chosen: NumberedRobot | None, lines: int
) -> Sequence[NumberedRobot]:
    """Return as many robots as there are lines for, the chosen one among them."""
    place = robots.index(chosen) if chosen else 0
    first = max(0, min(place - lines // 2, len(robots) - lines))
    return robots[first : first + lines]


def _alarm_lines(alarms: Sequence[Alarm], now: float, lines: int) -> Group:
    """Return the worst alarms, a line each; the last line counts those that have none."""
    shown = alarms if len(alarms) <= lines else alarms[: lines - 1]
    texts = [_line(alarm_words(alarm, now), STYLES.get(alarm.severity, "")) for alarm in shown]
    if len(shown) < len(alarms):
        texts.append(_line(f"and {len(alarms) - len(shown)} more alarms", ""))
    return Group(*texts)


def _details(watch: Watch, chosen: NumberedRobot | None) -> Group:
    """Return a robot's alarms, uncut, and its details; nothing of none."""
    if chosen is None:
        return Group()
    name, *lines = map(printable, detail_lines(watch, chosen.robot))
    own = [alarm for alarm in active_alarms(watch) if alarm.robot == chosen.robot.id]
    texts = [Text(printable(alarm.text), style=STYLES.get(alarm.severity, "")) for alarm in own]
    texts += [Text(line) for line in lines]
    return Group(Text(name, style="bold"), *(Padding(text, (0, 0, 0, 2)) for text in texts))


def _line(words: str, style: str) -> Text:
    return Text(words, style=style, no_wrap=True, overflow="ellipsis")


def plain_view(watch: Watch, choice: RobotChoice | None = None) -> str:
    """Return alarms, robots and details of one as lines of text, none of them cut.

    choice: whose details; None: of no robot.
    """
    out = io.StringIO()
    console = Console(file=out, width=ENDLESS, color_system=None, force_terminal=False)
    alarms, robots = active_alarms(watch), numbered_robots(watch)
    lines = [Text(alarm_words(alarm, watch.now)) for alarm in alarms]
    details = _details(watch, None if choice is None else choice.chosen(robots))
    table = robots_table(robots, watch, None)
    console.print(Group(headline(watch, alarms), *lines, table, details))
    return "\n".join(line.rstrip() for line in out.getvalue().splitlines() if line.strip())


def show_team(
    watch: Watch,
    going_on: Callable[[], bool],
    *,
    robot: str | None = None,
    out: TextIO | None = None,
    period: float = PLAIN_PERIOD_S,
) -> None:
    """Show a team until ``going_on`` returns False or ``q`` is typed.

    A terminal gets a live view and is left as it was; any other ``out`` (default: standard output)
    gets plain text every ``period`` seconds, and once at the end. robot: whose details, at first.
    """
    out = sys.stdout if out is None else out
    if out.isatty() and not Console(file=out).is_dumb_terminal:
        _show_live(watch, going_on, out, RobotChoice(robot))
    else:
        choice = None if robot is None else RobotChoice(robot)
        _print_plain(watch, going_on, out, period, choice)


def _show_live(
    watch: Watch, going_on: Callable[[], bool], out: TextIO, choice: RobotChoice
) -> None:
    """Draw on the terminal's other screen, so that its own one is untouched."""
    console = Console(file=out)
    with (
        view_keys(out.fileno()) as typed,
        Live(console=console, auto_refresh=False, screen=True) as live,
    ):
        while going_on() and not choice.ended:
            size = terminal_size(out.fileno())  # anew: it may have been resized
            console.size = ConsoleDimensions(*size)
            live.update(team_view(watch, choice, size), refresh=True)
            choice.type(typed(REFRESH_S), numbered_robots(watch))


def terminal_size(terminal: int) -> Size:
    """Return a terminal's size; 80 by 24 for one that does not know its own."""
    width, height = os.get_terminal_size(terminal)
    return Size(width or 80, height or 24)


def _print_plain(
    watch: Watch,
    going_on: Callable[[], bool],
    out: TextIO,
    period: float,
    choice: RobotChoice | None,
) -> None:
    due = time.monotonic() + period
    while going_on():
        time.sleep(REFRESH_S)
        if time.monotonic() >= due:
            due += period
            print(plain_view(watch, choice), file=out, flush=True)
    print(plain_view(watch, choice), file=out, flush=True)

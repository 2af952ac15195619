from __future__ import annotations

import io
import os
import pty
import re
import select
import socket
import termios
import threading
from collections.abc import Callable, Iterator
from contextlib import closing
from functools import cache
from itertools import count

import pytest
from rich.cells import cell_len
from rich.console import Console

from robot_agent.config import TelemetrySettings
from robot_agent.messages.streams import DecisionPayload, StatusPayload, encode
from robot_agent.process.telemetry import Telemetry
from tests.tools.monitor.agent_recordings import FOLDER, START
from tests.tools.monitor.reports import decision, status
from tests.tools.monitor.trouble_team import TROUBLE_AT, team_payloads
from tools.monitor.monitor import Monitor, MonitorOptions, until
from tools.monitor.robot_choice import RobotChoice
from tools.monitor.robot_row import names_of, numbered_robots, row_of
from tools.monitor.site import Site
from tools.monitor.team_state import TeamState
from tools.monitor.text_view import Size, plain_view, shares_of, show_team, team_view
from tools.monitor.watch import Watch

SMALL, LARGE = Size(80, 24), Size(120, 40)


@cache
def trouble_watch(robots: int) -> Watch:
    """Return a team 12 s into its trouble."""
    watch = Watch(TeamState(), Site(FOLDER))
    end, advanced = TROUBLE_AT + 12.0, 0.0
    for t, key, payload in team_payloads(robots, end):
        if t < TROUBLE_AT - 8.0:
            continue
        watch.team.receive(key, encode(payload), t, START + t)
        if t - advanced >= 0.2:
            watch.advance(t, START + t)
            advanced = t
    return watch


def one_robot(*payloads: StatusPayload | DecisionPayload) -> Watch:
    watch = Watch(TeamState(), Site(None))
    watch.team.set_liveliness("patrol/north/anna", online=True)
    for payload in payloads:
        stream = "status" if isinstance(payload, StatusPayload) else "decision"
        watch.team.receive(f"patrol/north/anna/{stream}", encode(payload), 100.0, 1.5)
    watch.advance(100.1, 1.6)
    return watch


def capture(watch: Watch, size: Size, choice: RobotChoice | None = None) -> list[str]:
    """Return the lines that a terminal of a size shows."""
    out = io.StringIO()
    console = Console(file=out, width=size.width, height=size.height, color_system=None)
    console.print(team_view(watch, choice or RobotChoice(), size))
    return out.getvalue().removesuffix("\n").split("\n")


def line_with(lines: list[str], words: str) -> int:
    return next(number for number, line in enumerate(lines) if words in line)


@pytest.mark.parametrize("size", [SMALL, LARGE])
@pytest.mark.parametrize("robots", [3, 20])
def test_view_fills_the_terminal_and_no_line_is_longer(robots: int, size: Size) -> None:
    lines = capture(trouble_watch(robots), size)
    assert len(lines) == size.height
    assert max(map(cell_len, lines)) <= size.width


@pytest.mark.parametrize("size", [SMALL, LARGE])
def test_three_robots_have_a_line_each_below_the_alarms(size: Size) -> None:
    lines = capture(trouble_watch(3), size)
    assert re.match(r"\d critical.*; 3 robots; border unseen for", lines[0])
    assert "CRITICAL" in lines[1]
    heading = line_with(lines, " doing")
    assert all("CRITICAL" not in line and "WARNING" not in line for line in lines[heading:])
    rows = lines[heading + 1 : heading + 4]
    assert sorted(re.findall(r"robot\d", "".join(rows))) == ["robot1", "robot2", "robot3"]
    assert any("robot3" in row and "held by the gate: no fresh laser scan" in row for row in rows)
    assert lines[-1].startswith("up and down or a number choose a robot")


def test_alarm_that_a_line_cuts_is_whole_in_the_details() -> None:
    lines = capture(trouble_watch(3), SMALL)
    assert lines[1].endswith("at s = 5.…")
    details = " ".join(line.strip() for line in lines[lines.index(f"{'north/robot2':<80}") + 1 :])
    assert "intruder at 9.5, 14.6 m, 0.9 m from the border at s = 5.5 m" in details


def test_twenty_robots_are_all_seen_on_a_large_terminal() -> None:
    lines = capture(trouble_watch(20), LARGE)
    heading = line_with(lines, " doing")
    rows = lines[heading + 1 : heading + 21]
    names = {found for row in rows for found in re.findall(r"robot\d+", row)[:1]}
    assert names == {f"robot{number}" for number in range(1, 21)}
    assert all(row.startswith(("!", " ")) for row in rows)
    assert rows[-1].startswith("  "), "those in trouble come first"


def test_twenty_robots_on_a_small_terminal_scroll_with_the_choice() -> None:
    choice = RobotChoice("robot20")
    lines = capture(trouble_watch(20), SMALL, choice)
    assert any(line.startswith("   20 robot20 ") for line in lines)
    assert re.match(r"\d+ more robots; ", lines[-1])
    assert f"{'north/robot20':<80}" in lines


def test_worst_robot_is_chosen_until_a_key_chooses_another() -> None:
    watch = trouble_watch(20)
    robots = numbered_robots(watch)
    choice = RobotChoice()
    assert choice.chosen(robots) is robots[0]
    for typed, number in (
        (b"\x1b[B", robots[1].number),
        (b"k", robots[0].number),
        (b"\x1b[A", robots[0].number),
        (b"1", 1),
        (b"2", 12),
        (b"5", 5),
        (b"jk", 5),
        (b"99", 9),
        (b"\x1b", robots[0].number),
    ):
        choice.type(typed, robots)
        chosen = choice.chosen(robots)
        assert chosen is not None
        assert chosen.number == number, typed
    assert not choice.ended
    choice.type(b"q", robots)
    assert choice.ended


def test_keys_before_any_robot_do_no_harm() -> None:
    choice = RobotChoice()
    choice.type(b"j1\x1b[Ak", [])
    assert choice.chosen([]) is None
    assert "no robot has reported yet" in capture(Watch(TeamState(), Site(None)), SMALL)[0]


def test_alarms_without_a_line_are_counted() -> None:
    assert shares_of(24, 9, 3) == (4, 3)
    lines = capture(trouble_watch(20), Size(80, 18))
    assert re.match(r"and \d+ more alarms", lines[3])


def test_row_holds_what_a_robot_does_and_why() -> None:
    watch = one_robot(status(0.5, battery=12.34), decision(0.5, distance_from_neighbor=1.8))
    (robot,) = numbered_robots(watch)
    assert row_of(robot, 100.7, names_of(watch.robots))._asdict() == {
        "mark": "",
        "number": "1",
        "robot": "anna",
        "battery": "12.3 V",
        "heard": "0.7 s",
        "s": "3.0",
        "border": "0.02 m",
        "speed": "0.35",
        "pose": "localized",
        "doing": "keeps going clockwise, teammate 1.8 m away",
    }


def test_row_of_a_silent_robot_has_no_figures() -> None:
    watch = one_robot()
    (robot,) = numbered_robots(watch)
    row = row_of(robot, 105.0, names_of(watch.robots))
    assert (row.heard, row.doing) == ("never", "nothing received")
    assert {row.battery, row.s, row.border, row.speed, row.pose} == {"-"}


def test_number_is_the_one_that_the_name_ends_in() -> None:
    numbers = {each.robot.robot: each.number for each in numbered_robots(trouble_watch(20))}
    assert numbers == {f"robot{number}": number for number in range(1, 21)}
    watch = one_robot(status(0.5))
    for name in ("bob1", "carl1", "dora0"):
        watch.team.receive(f"patrol/north/{name}/status", encode(status(0.5)), 100.0, 1.5)
    watch.advance(100.2, 1.7)
    numbers = {each.robot.robot: each.number for each in numbered_robots(watch)}
    assert numbers == {"bob1": 1, "anna": 2, "carl1": 3, "dora0": 4}


def test_team_is_named_where_there_are_several() -> None:
    watch = one_robot(status(0.5))
    watch.team.receive("patrol/south/anna/status", encode(status(0.5)), 100.0, 1.5)
    watch.advance(100.2, 1.7)
    assert {"north/anna", "south/anna"} <= set(plain_view(watch).split())


def test_text_from_the_network_is_escaped() -> None:
    watch = one_robot(status(0.5), decision(0.5, action="[bold]/", gate_reason="\x1b[2J"))
    shown = "\n".join(capture(watch, LARGE)) + plain_view(watch, RobotChoice())
    assert shown.count("[bold]/") >= 2
    assert "\x1b" not in shown


def test_wide_names_do_not_lengthen_a_line() -> None:
    watch = one_robot(status(0.5), decision(0.5, action="巡" * 90))
    assert max(map(cell_len, capture(watch, SMALL))) <= 80


def test_alarms_come_first_in_plain_text() -> None:
    watch = one_robot(status(0.5, battery=11.2, uptime=60.0))
    watch.advance(101.1, 2.6)
    head, alarm, *_ = plain_view(watch).splitlines()
    assert head.startswith("1 warning; 1 robot")
    assert alarm == "WARNING north/anna: battery at 11.2 V (1 s ago)"


def test_details_hold_every_figure_of_the_chosen_robot() -> None:
    degrees = {"patrol_clockwise": 0.83, "keep_going": 0.17}
    watch = one_robot(
        status(0.5),
        decision(0.5, degrees=degrees, winner="patrol_clockwise", runner_up="keep_going"),
    )
    shown = plain_view(watch, RobotChoice("anna"))
    for words in (
        "\nnorth/anna\n",
        "keep going 0.17 (second), patrol clockwise 0.83 (first)",
        "asked for 0.35 m/s 0.00 rad/s, the gate lets 0.35 m/s 0.00 rad/s",
        "0.02 m from the border, at 3.0 m of the border",
        "health ok, motors on",
        "base ready, 0 bad, 0 bytes lost",
        "clock -1.00 s",
    ):
        assert words in shown
    assert "north/anna" not in plain_view(watch), "no details without a choice"


@pytest.fixture
def endpoint() -> str:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return f"tcp/127.0.0.1:{probe.getsockname()[1]}"


def test_monitor_prints_plain_text_without_a_terminal(endpoint: str) -> None:
    robot = Telemetry(TelemetrySettings(operator=endpoint), robot="anna", team="north")
    shown, out = threading.Event(), io.StringIO()

    def report() -> None:
        while not shown.wait(0.05):
            robot.publish("decision", encode(decision(1.0)))

    reporter = threading.Thread(target=report)
    reporter.start()
    try:
        with closing(Monitor(MonitorOptions(endpoint, None, Site(None)))) as monitor:
            show_team(monitor.watch, until(1.2), out=out, period=60.0)
    finally:
        shown.set()
        reporter.join()
        robot.close()
    assert re.search(r"^ *1 anna .* keeps going clockwise", out.getvalue(), re.MULTILINE)


class Terminal:
    """A pseudo-terminal with what has been drawn on it."""

    def __init__(self, size: Size) -> None:
        self.keyboard, self.end = pty.openpty()
        self.resize(size)
        self.out = os.fdopen(self.end, "w")
        self.drawn = b""

    def resize(self, size: Size) -> None:
        termios.tcsetwinsize(self.end, (size.height, size.width))

    def read(self) -> bytes:
        """Take what has been drawn since the last time."""
        new = b""
        while select.select([self.keyboard], [], [], 0)[0]:
            new += os.read(self.keyboard, 65536)
        self.drawn += new
        return new

    def close(self) -> None:
        self.out.close()
        os.close(self.keyboard)


@pytest.fixture
def terminal(monkeypatch: pytest.MonkeyPatch) -> Iterator[Terminal]:
    monkeypatch.setenv("TERM", "xterm")
    terminal = Terminal(SMALL)
    yield terminal
    terminal.close()


def frames(drawn: bytes) -> list[list[str]]:
    """Return the lines of each full drawing of the screen."""
    text = re.sub(r"\x1b\[[0-9;]*m", "", drawn.decode())
    return [part.split("\r\n") for part in re.split(r"\x1b\[H", text)[1:] if "robot3" in part]


def drawing(terminal: Terminal, steps: dict[int, Callable[[], object]], rounds: int) -> None:
    """Show a team for some drawings; call each step before its drawing."""
    numbers = count()

    def going_on() -> bool:
        terminal.read()
        number = next(numbers)
        steps.get(number, lambda: None)()
        return number < rounds

    show_team(trouble_watch(3), going_on, out=terminal.out)


def test_resized_terminal_is_drawn_anew_at_its_size(terminal: Terminal) -> None:
    drawing(terminal, {1: lambda: terminal.resize(LARGE), 2: lambda: terminal.resize(SMALL)}, 3)
    terminal.read()
    drawn = frames(terminal.drawn)
    sizes = [(len(lines), max(map(len, lines[:-1]))) for lines in drawn]
    assert sizes == [(24, 80), (40, 120), (24, 80)]


def test_end_leaves_the_terminal_as_it_was(terminal: Terminal) -> None:
    before = termios.tcgetattr(terminal.end)
    with pytest.raises(KeyboardInterrupt):
        drawing(terminal, {1: interrupt}, 5)
    terminal.read()
    assert termios.tcgetattr(terminal.end) == before
    assert terminal.drawn.startswith(b"\x1b[?1049h"), "the other screen"
    left = terminal.drawn[terminal.drawn.rindex(b"\x1b[?1049l") :]
    assert b"robot" not in left
    assert b"\x1b[?25h" in terminal.drawn[-40:], "the cursor is seen again"


def interrupt() -> None:
    raise KeyboardInterrupt


def test_dumb_terminal_gets_plain_text(terminal: Terminal, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TERM", "dumb")
    drawing(terminal, {}, 1)
    assert b"\x1b" not in terminal.read()
    assert b"robot3" in terminal.drawn

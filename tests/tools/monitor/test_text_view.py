from __future__ import annotations

import io
import socket
import threading
from contextlib import closing

import msgspec
import pytest
from rich.console import Console

from maps.pose import Pose
from robot_agent.config import TelemetrySettings
from robot_agent.messages.foxglove import PoseInFrame, Timestamp, pose3
from robot_agent.messages.streams import (
    DecisionPayload,
    DeviceStatus,
    LocalizationStatus,
    PlanarPose,
    StatusPayload,
    Twist,
    Velocity,
    encode,
)
from robot_agent.process.telemetry import Telemetry
from tools.monitor.monitor import Monitor, MonitorOptions, until
from tools.monitor.robot_state import RobotState
from tools.monitor.site import Site
from tools.monitor.team_state import TeamState
from tools.monitor.text_view import Row, plain_table, plain_view, row_of, show_team, team_table
from tools.monitor.watch import Watch

NOW = Timestamp(sec=1, nsec=0)


def device(state: str) -> DeviceStatus:
    return DeviceStatus(
        state=state,
        link_up=True,
        packets_good=1,
        packets_bad=0,
        bytes_discarded=0,
        bytes_received=20,
    )


POSE = PoseInFrame(timestamp=NOW, frame_id="map", pose=pose3(Pose(1.0, -2.0, 1.5707963)))
STATUS = StatusPayload(
    timestamp=NOW,
    robot="anna",
    team="north",
    uptime=3.0,
    health="ok",
    battery=12.34,
    base=device("ready"),
    laser=device("streaming"),
    localization=LocalizationStatus(health="unsure"),
)
DECISION = DecisionPayload(
    timestamp=NOW,
    robot="anna",
    action="patrol_clockwise",
    direction=1,
    distance_from_border=0.031,
    abscissa=17.0,
    distance_from_neighbor=1.8,
    degrees={},
    winner="patrol_clockwise",
    runner_up="keep_going",
    pose=PlanarPose(1.0, -2.0, 1.57),
    velocity=Velocity(0.0, 0.35),
    requested=Twist(0.35, 0.0),
    command=Twist(0.2, -0.1),
    gate_reason="obstacle ahead",
)


def team_with(*payloads: StatusPayload | DecisionPayload | PoseInFrame) -> list[RobotState]:
    team = TeamState()
    team.set_liveliness("patrol/north/anna", online=True)
    streams = {StatusPayload: "status", DecisionPayload: "decision", PoseInFrame: "pose"}
    for payload in payloads:
        team.receive(f"patrol/north/anna/{streams[type(payload)]}", encode(payload), 100.0)
    return team.snapshot()


def test_row_holds_every_figure_of_a_robot() -> None:
    (robot,) = team_with(POSE, STATUS, DECISION)
    assert row_of(robot, 100.7) == Row(
        robot="north/anna",
        pose="1.00 -2.00 90°",
        action="patrol_clockwise (cw)",
        border="0.03 m",
        teammate="1.80 m",
        battery="12.3 V",
        base="ready",
        laser="streaming",
        localization="unsure",
        speed="0.20 m/s -0.10 rad/s",
        gate="obstacle ahead",
        age="0.7 s",
        why="patrols clockwise, teammate 1.8 m away",
    )


def test_row_of_a_silent_robot_has_no_figures() -> None:
    (robot,) = team_with()
    row = row_of(robot, 5.0)
    assert row.robot == "north/anna"
    assert row.age == "never"
    assert row.why == "nothing received"
    assert set(row) - {row.robot, row.age, row.why} == {"-"}


def test_offline_robot_is_marked_with_its_age() -> None:
    team = TeamState()
    team.receive("patrol/north/anna/status", encode(STATUS), 100.0)
    (robot,) = team.snapshot()
    assert row_of(robot, 130.0).age == "offline (30.0 s)"


def test_plain_table_is_aligned() -> None:
    heading, row = plain_table(team_with(STATUS, DECISION), 100.0).splitlines()
    assert heading.split() == list(Row._fields)
    assert heading.index("battery") == row.index("12.3 V")
    assert heading.index("gate") == row.index("obstacle ahead")


def test_text_from_the_network_is_escaped() -> None:
    hostile = msgspec.structs.replace(DECISION, action="[bold]/", gate_reason="\x1b[2J")
    team = team_with(STATUS, hostile)
    console = Console(file=io.StringIO(), width=400)
    console.print(team_table(team, 100.0))
    shown = console.file.getvalue() + plain_table(team, 100.0)  # type: ignore[attr-defined]
    assert shown.count("[bold]/ (cw)") == 2
    assert "\x1b" not in shown


def test_active_alarms_are_printed_below_the_table() -> None:
    team = TeamState()
    watch = Watch(team, Site(None))
    weak = msgspec.structs.replace(STATUS, battery=11.2, uptime=60.0)
    team.receive("patrol/north/anna/status", encode(weak), 100.0, 1.0)
    watch.advance(100.1, 1.1)
    watch.advance(101.1, 2.1)
    _, _, alarm, _ = plain_view(watch).splitlines()
    assert alarm == "WARNING north/anna: battery at 11.2 V (1 s ago)"


def test_details_are_printed_below_the_table() -> None:
    team = TeamState()
    watch = Watch(team, Site(None))
    degrees = {"patrol_clockwise": 0.83, "keep_going": 0.17}
    decided = msgspec.structs.replace(DECISION, degrees=degrees)
    for stream, payload in (("status", STATUS), ("decision", decided)):
        team.receive(f"patrol/north/anna/{stream}", encode(payload), 100.0, 1.5)
    watch.advance(100.1, 1.6)
    *_, details = plain_view(watch).splitlines()
    for words in (
        "north/anna: reach_frontier 0.00",
        "keep_going 0.17 (second), patrol_clockwise 0.83 (first)",
        "asked for 0.35 m/s 0.00 rad/s",
        "at 17.0 m of the border",
        "motors off",
        "base 0 bad, 0 bytes lost",
        "clock -0.50 s",
    ):
        assert words in details


@pytest.fixture
def endpoint() -> str:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return f"tcp/127.0.0.1:{probe.getsockname()[1]}"


def monitor_a_robot(endpoint: str, out: io.StringIO) -> str:
    """Run the monitor while a robot reports; return its output."""
    robot = Telemetry(TelemetrySettings(operator=endpoint), robot="anna", team="north")
    shown = threading.Event()

    def report() -> None:
        while not shown.wait(0.05):
            robot.publish("decision", encode(DECISION))

    reporter = threading.Thread(target=report)
    reporter.start()
    try:
        with closing(Monitor(MonitorOptions(endpoint, None, Site(None)))) as monitor:
            show_team(monitor.watch, until(1.2), out=out, period=60.0)
    finally:
        shown.set()
        reporter.join()
        robot.close()
    return out.getvalue()


def test_monitor_prints_plain_text_without_a_terminal(endpoint: str) -> None:
    heading, row, *_ = monitor_a_robot(endpoint, io.StringIO()).splitlines()
    assert heading.startswith("robot")
    assert row.startswith("north/anna")
    assert "patrol_clockwise (cw)" in row


class Terminal(io.StringIO):
    """An output that is a terminal."""

    def isatty(self) -> bool:
        return True


def test_monitor_shows_a_live_table_in_a_terminal(
    endpoint: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "220")
    monkeypatch.setenv("TERM", "xterm")
    shown = monitor_a_robot(endpoint, Terminal())
    assert "north/anna" in shown
    assert "patrol_clockwise (cw)" in shown

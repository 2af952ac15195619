from __future__ import annotations

import socket
import time
from collections.abc import Callable
from contextlib import closing

import pytest
import zenoh

from maps.input_limits import MAX_MESSAGE_BYTES, MAX_PAYLOAD_BYTES
from maps.pose import Pose
from robot_agent.config import TelemetrySettings
from robot_agent.messages.foxglove import PoseInFrame, Timestamp, pose3
from robot_agent.messages.streams import encode
from robot_agent.process.telemetry import Telemetry, session_config
from tools.monitor.operator import Operator, OperatorError

TIMEOUT_S = 15.0
POSE = PoseInFrame(
    timestamp=Timestamp(sec=1, nsec=0), frame_id="map", pose=pose3(Pose(1.0, 2.0, 0.5))
)


@pytest.fixture
def endpoint() -> str:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return f"tcp/127.0.0.1:{probe.getsockname()[1]}"


def wait_until(condition: Callable[[], bool]) -> None:
    deadline = time.monotonic() + TIMEOUT_S
    while not condition():
        assert time.monotonic() < deadline, "nothing happened"
        time.sleep(0.01)


def test_team_state_follows_the_robots_reports(endpoint: str) -> None:
    with closing(Operator(endpoint)) as operator:
        robots = {
            name: Telemetry(TelemetrySettings(operator=endpoint), robot=name, team="north")
            for name in ("anna", "bob")
        }
        wait_until(lambda: [robot.online for robot in operator.team.snapshot()] == [True, True])
        robots["bob"].publish("pose", encode(POSE))
        wait_until(lambda: operator.team.snapshot()[1].pose == POSE)
        robots["bob"].close()
        wait_until(lambda: [robot.online for robot in operator.team.snapshot()] == [True, False])
        anna, bob = operator.team.snapshot()
        assert (anna.pose, bob.pose) == (None, POSE)
        robots["anna"].close()


def test_two_sessions_under_one_name_are_rivals(endpoint: str) -> None:
    with closing(Operator(endpoint)) as operator:
        settings = TelemetrySettings(operator=endpoint)
        pair = [Telemetry(settings, robot="anna", team="north") for _ in range(2)]
        wait_until(lambda: all(one.connected for one in pair))
        rivals = []
        for number in range(4):
            pair[number % 2].publish("pose", encode(POSE))
            wait_until(lambda n=number: len(operator.team.snapshot()[0].poses) == n + 1)
            rivals.append(operator.team.snapshot()[0].rivals_at is not None)
        assert rivals == [False, False, True, True]
        for one in pair:
            one.close()


def test_malformed_payload_is_counted(endpoint: str) -> None:
    with closing(Operator(endpoint)) as operator:
        robot = Telemetry(TelemetrySettings(operator=endpoint), robot="anna", team="north")
        wait_until(lambda: bool(operator.team.snapshot()))
        robot.publish("pose", b"not JSON")
        wait_until(lambda: operator.team.snapshot()[0].malformed == 1)
        robot.close()


def test_oversize_payloads_are_dropped_before_they_are_kept(endpoint: str) -> None:
    kept: list[int] = []
    with (
        closing(Operator(endpoint, [lambda _key, data, _wall: kept.append(len(data))])) as operator,
        zenoh.open(session_config(endpoint)) as stranger,
    ):
        wait_until(lambda: bool(stranger.info.routers_zid()))
        for size in (MAX_MESSAGE_BYTES * 2, MAX_PAYLOAD_BYTES + 1, 2):
            # Not dropped where the machine is slow.
            block = zenoh.CongestionControl.BLOCK
            stranger.put("patrol/north/anna/pose", b"1" * size, congestion_control=block)
        wait_until(lambda: bool(kept))
        (robot,) = operator.team.snapshot()
        assert kept == [2]
        assert robot.malformed == 2, "the largest never left the door"


def test_deletions_and_other_keys_are_ignored(endpoint: str) -> None:
    with closing(Operator(endpoint)) as operator, zenoh.open(session_config(endpoint)) as stranger:
        wait_until(lambda: bool(stranger.info.routers_zid()))
        stranger.delete("patrol/north/anna/status")
        stranger.put("elsewhere/north/anna/status", b"{}")
        stranger.put("patrol/north/zoe/pose", encode(POSE))
        wait_until(lambda: bool(operator.team.snapshot()))
        (robot,) = operator.team.snapshot()
        assert (robot.robot, robot.malformed, operator.team.stray) == ("zoe", 0, 0)


def test_taken_endpoint_is_one_error(endpoint: str) -> None:
    with closing(Operator(endpoint)), pytest.raises(OperatorError) as raised:
        Operator(endpoint)
    message = str(raised.value)
    assert message.startswith(f"cannot listen on {endpoint}: ")
    assert "Address already in use" in message
    assert "\n" not in message


def test_close_is_idempotent_and_frees_the_endpoint(endpoint: str) -> None:
    operator = Operator(endpoint)
    operator.close()
    operator.close()
    Operator(endpoint).close()

from __future__ import annotations

import hypothesis.strategies as st
import pytest
from hypothesis import given, settings

from maps.pose import Pose
from robot_agent.messages.foxglove import PoseInFrame, Timestamp, pose3
from robot_agent.messages.streams import STREAMS, encode
from tools.monitor.team_state import MAX_ROBOTS, TeamState

POSE = PoseInFrame(
    timestamp=Timestamp(sec=1, nsec=0), frame_id="map", pose=pose3(Pose(1.0, 2.0, 0.5))
)


def test_newest_payload_and_its_time_are_kept() -> None:
    team = TeamState()
    older = PoseInFrame(timestamp=POSE.timestamp, frame_id="odom", pose=POSE.pose)
    team.receive("patrol/north/anna/pose", encode(older), 10.0)
    team.receive("patrol/north/anna/pose", encode(POSE), 10.5)
    (robot,) = team.snapshot()
    assert (robot.team, robot.robot) == ("north", "anna")
    assert robot.pose == POSE
    assert robot.received == {"pose": 10.5}
    assert robot.last_heard == 10.5
    assert (robot.status, robot.decision) == (None, None)


def test_offline_robot_keeps_its_last_payloads() -> None:
    team = TeamState()
    team.set_liveliness("patrol/north/anna", online=True)
    assert [robot.online for robot in team.snapshot()] == [True]
    team.receive("patrol/north/anna/pose", encode(POSE), 3.0)
    team.set_liveliness("patrol/north/anna", online=False)
    (robot,) = team.snapshot()
    assert not robot.online
    assert robot.pose == POSE


def test_malformed_payloads_are_only_counted() -> None:
    team = TeamState()
    team.receive("patrol/north/anna/pose", encode(POSE), 1.0)
    for data in (b"", b"{", b"\xff", b'{"pose": 3}'):
        team.receive("patrol/north/anna/pose", data, 2.0)
    team.receive("patrol/north/anna/nonsense", b"{}", 2.0)
    (robot,) = team.snapshot()
    assert robot.malformed == 5
    assert robot.pose == POSE
    assert robot.last_heard == 1.0


def test_snapshot_is_ordered_by_team_and_name() -> None:
    team = TeamState()
    for name in ("south/bob", "north/carl", "north/anna"):
        team.set_liveliness(f"patrol/{name}", online=True)
    assert [f"{robot.team}/{robot.robot}" for robot in team.snapshot()] == [
        "north/anna",
        "north/carl",
        "south/bob",
    ]


def test_robots_beyond_the_maximum_are_stray() -> None:
    team = TeamState()
    for number in range(MAX_ROBOTS + 10):
        team.set_liveliness(f"patrol/north/robot{number}", online=True)
    assert len(team.snapshot()) == MAX_ROBOTS
    assert team.stray == 10


@pytest.mark.parametrize("key", ["", "patrol", "patrol/north/pose", "other/north/anna/pose", "a/b"])
def test_key_of_no_robot_is_counted_as_stray(key: str) -> None:
    team = TeamState()
    team.receive(key, encode(POSE), 1.0)
    team.set_liveliness(key + "/x/y/z", online=True)
    assert team.stray == 2
    assert team.snapshot() == []


keys = st.one_of(
    st.text(max_size=30),
    st.builds("patrol/t/{}/{}".format, st.text(max_size=5), st.sampled_from([*STREAMS, "x"])),
)


@settings(max_examples=200, deadline=None)
@given(messages=st.lists(st.tuples(keys, st.binary(max_size=40)), max_size=10))
def test_arbitrary_messages_do_not_raise(messages: list[tuple[str, bytes]]) -> None:
    team = TeamState()
    for key, data in messages:
        team.receive(key, data, 0.0)
        team.set_liveliness(key, online=True)
    counted = team.stray + sum(robot.malformed for robot in team.snapshot())
    assert counted >= len(messages)

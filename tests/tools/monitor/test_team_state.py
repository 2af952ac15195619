from __future__ import annotations

import hypothesis.strategies as st
import pytest
from hypothesis import given, settings

from maps.pose import Pose
from robot_agent.messages.foxglove import PoseInFrame, Timestamp, pose3
from robot_agent.messages.streams import STREAMS, encode
from tests.tools.monitor.reports import status
from tools.monitor.team_state import GIVE_WAY_S, MAX_ROBOTS, TeamState

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


def full_team() -> TeamState:
    """Return as many robots as are kept, all online and heard at 0 s."""
    team = TeamState()
    for number in range(MAX_ROBOTS):
        team.set_liveliness(f"patrol/north/robot{number}", online=True)
        team.receive(f"patrol/north/robot{number}/pose", encode(POSE), 0.0)
    return team


def names(team: TeamState) -> set[str]:
    return {robot.id for robot in team.snapshot()}


def test_robot_beyond_the_maximum_is_hidden_while_all_others_report() -> None:
    team = full_team()
    for number in range(10):
        team.set_liveliness(f"patrol/north/more{number}", online=True, t=1.0)
    assert len(team.snapshot()) == MAX_ROBOTS
    assert len(team.hidden_since(0.5)) == 10
    assert team.hidden_since(1.5) == []
    assert team.stray == 0


def test_silent_robot_gives_way_and_is_named() -> None:
    team = full_team()
    for number in range(1, MAX_ROBOTS):
        team.receive(f"patrol/north/robot{number}/pose", encode(POSE), GIVE_WAY_S + 1.0)
    team.receive("patrol/north/more/pose", encode(POSE), GIVE_WAY_S + 1.0)
    assert "north/more" in names(team)
    assert "north/robot0" not in names(team)
    assert team.hidden_since(0.0) == ["north/robot0"]


def test_robot_that_came_online_without_room_is_online_once_it_is_shown() -> None:
    team = TeamState()
    for number in range(MAX_ROBOTS):
        team.receive(f"patrol/north/robot{number}/pose", encode(POSE), 0.0)
    team.set_liveliness("patrol/north/late", online=True, t=1.0)
    team.set_liveliness("patrol/north/gone", online=True, t=1.0)
    team.set_liveliness("patrol/north/gone", online=False, t=2.0)
    for name in ("late", "gone"):
        team.receive(f"patrol/north/{name}/pose", encode(POSE), GIVE_WAY_S + 1.0)
    online = {robot.robot: robot.online for robot in team.snapshot()}
    assert (online["late"], online["gone"]) == (True, False)


def test_presence_of_invented_names_is_bounded() -> None:
    team = TeamState()
    for number in range(5000):
        team.set_liveliness(f"patrol/north/x{number}", online=True)
    assert len(team._online) < 2000


def test_of_silent_robots_the_offline_one_gives_way_first() -> None:
    team = full_team()
    team.set_liveliness("patrol/north/robot7", online=False, t=1.0)
    team.receive("patrol/north/more/pose", encode(POSE), 20.0)
    assert "north/robot7" not in names(team)


def test_invented_names_do_not_keep_later_robots_out_for_long() -> None:
    team = TeamState()
    for number in range(MAX_ROBOTS):
        team.set_liveliness(f"patrol/x/invented{number}", online=True, t=0.0)
        team.receive(f"patrol/x/invented{number}/pose", b"junk", 100.0)
    team.receive("patrol/north/anna/pose", encode(POSE), 100.0)
    assert "north/anna" in names(team), "junk is no report"
    for number in range(1000):
        team.receive(f"patrol/x/other{number}/pose", encode(POSE), 101.0)
        team.receive("patrol/north/anna/pose", encode(POSE), 101.0)
    assert "north/anna" in names(team), "a robot that reports keeps its place"
    assert len(team.hidden) <= MAX_ROBOTS


def test_sessions_that_take_turns_are_rivals_and_a_restart_is_none() -> None:
    team = TeamState()
    for t, source in ((0.0, "a"), (0.1, "a"), (1.0, "b"), (1.1, "b")):
        team.receive("patrol/north/anna/pose", encode(POSE), t, t, source)
    assert team.snapshot()[0].rivals_at is None
    team.receive("patrol/north/anna/pose", encode(POSE), 1.2, 1.2, "a")
    assert team.snapshot()[0].rivals_at == 1.2


@pytest.mark.parametrize(("clock", "rivals_at"), [(0.0, 2.2), (0.6, None)])
def test_payload_without_stamp_is_a_rivals_unless_the_clock_explains_it(
    clock: float, rivals_at: float | None
) -> None:
    team = TeamState()
    team.receive("patrol/north/anna/status", encode(status(2.0 + clock)), 2.0, 2.0, "a")
    for t, source in ((2.1, ""), (2.2, "a")):
        team.receive("patrol/north/anna/pose", encode(POSE), t, t, source)
    assert team.snapshot()[0].rivals_at == rivals_at


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


@settings(max_examples=200)
@given(messages=st.lists(st.tuples(keys, st.binary(max_size=40)), max_size=10))
def test_arbitrary_messages_do_not_raise(messages: list[tuple[str, bytes]]) -> None:
    team = TeamState()
    for key, data in messages:
        team.receive(key, data, 0.0)
        team.set_liveliness(key, online=True)
    counted = team.stray + sum(robot.malformed for robot in team.snapshot())
    assert counted >= len(messages)

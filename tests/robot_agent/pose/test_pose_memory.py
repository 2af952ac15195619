"""The pose over a restart: when it is stored, when it is valid, and that scans must confirm it."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest

from localization.estimate import Estimate
from localization.health import Health
from maps.map_folder import MapFolder, load_map_folder
from maps.pose import Pose
from robot_agent.agent import Agent
from robot_agent.config import AgentConfig, find_map, format_config, parse_config
from robot_agent.messages.effects import Remember
from robot_agent.pose.pose_memory import MemorySettings, PoseMemory, RememberedPose
from robot_agent.process.pose_file import PoseFile
from tests.robot_agent.tape import Tape
from tools.bench.fleet import Fleet
from tools.simulation.lockstep import LockstepAgent

START = Pose(5.0, 13.4, 0.3)
NOTED = RememberedPose(
    x=3.0, y=4.0, theta=1.0, odometer_x=5000, odometer_y=-2000, odometer_heading=1024
)
MM = 0.001  # metres per count
KEEPING = MemorySettings(file="pose.json")


# --- validity after a restart ----------------------------------------------------------------


def test_same_reading_gives_the_same_pose() -> None:
    start = NOTED.carried_to((5000, -2000, 1024), MM)
    assert start is not None
    assert start.pose == pytest.approx((3.0, 4.0, 1.0))


def test_pose_is_moved_by_the_counts_since() -> None:
    """The odometer's heading is a quarter turn: its y is ahead."""
    start = NOTED.carried_to((5000, -1500, 1024 + 512), MM)
    assert start is not None
    assert start.pose == pytest.approx(
        (3.0 + 0.5 * math.cos(1.0), 4.0 + 0.5 * math.sin(1.0), 1.0 + math.pi / 4)
    )
    unmoved = NOTED.carried_to((5000, -2000, 1024), MM)
    assert unmoved is not None
    assert start.sigma_xy > unmoved.sigma_xy
    assert start.sigma_theta > unmoved.sigma_theta


def test_wrapped_counters_continue() -> None:
    noted = msgspec.structs.replace(NOTED, odometer_x=0x7FF0, odometer_heading=4090)
    start = noted.carried_to((0x10, -2000, 2), MM)
    assert start is not None
    assert math.hypot(start.pose.x - 3.0, start.pose.y - 4.0) == pytest.approx(0.032)
    assert start.pose.theta == pytest.approx(1.0 + 8 * math.tau / 4096)


@pytest.mark.parametrize(
    "now", [(5000, -499, 1024), (0, 0, 0), (2, 0x7FFF, 1), (5000 + 4096, -2000, 1024)]
)
def test_odometer_too_far_on_or_zeroed_gives_none(now: tuple[int, int, int]) -> None:
    assert NOTED.carried_to(now, MM) is None


def test_pose_stored_at_zero_counts_gives_none() -> None:
    """Every odometer reads that after it was switched on."""
    noted = msgspec.structs.replace(NOTED, odometer_x=0, odometer_y=0, odometer_heading=0)
    assert noted.carried_to((300, 0, 0), MM) is None


# --- storing ---------------------------------------------------------------------------------


def estimate(health: Health) -> Estimate:
    return Estimate(
        t=0.0,
        pose=Pose(1.0, 2.0, 0.5),
        odometry=Pose(0.0, 0.0, 0.0),
        covariance=np.eye(3),
        health=health,
        particle_count=1,
        effective_sample_size=1.0,
        likelihood=1.0,
        refined=True,
    )


def note(
    memory: PoseMemory, t: float, health: Health, *, at_once: bool = False
) -> RememberedPose | str | None:
    found = memory.update(t, estimate(health), Pose(0.0, 0.0, 0.0), (7, 8, 9), at_once=at_once)
    if found is None:
        return None
    return (
        "forget"
        if found.payload == b"{}"
        else msgspec.json.decode(found.payload, type=RememberedPose)
    )


def test_localized_pose_is_stored_periodically_and_deleted_once_lost() -> None:
    memory = PoseMemory(KEEPING)
    expected = RememberedPose(
        x=1.0, y=2.0, theta=0.5, odometer_x=7, odometer_y=8, odometer_heading=9
    )
    assert note(memory, 0.0, Health.UNSURE) is None
    assert note(memory, 0.1, Health.LOCALIZED) == expected
    assert note(memory, 1.0, Health.LOCALIZED) is None
    assert note(memory, 1.0, Health.LOCALIZED, at_once=True) == expected
    assert note(memory, 2.1, Health.LOCALIZED) == expected
    assert note(memory, 7.0, Health.UNSURE, at_once=True) is None
    assert note(memory, 8.0, Health.LOST) == "forget"
    assert note(memory, 9.0, Health.LOST) is None
    assert note(memory, 9.1, Health.LOCALIZED) == expected


def test_without_a_file_nothing_is_stored() -> None:
    assert note(PoseMemory(MemorySettings()), 0.0, Health.LOCALIZED) is None
    assert PoseMemory(KEEPING).update(0.0, None, Pose(0.0, 0.0, 0.0), (7, 8, 9)) is None
    unread = PoseMemory(KEEPING).update(0.0, estimate(Health.LOCALIZED), Pose(0.0, 0.0, 0.0), None)
    assert unread is None


# --- the file --------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def folder() -> MapFolder:
    return load_map_folder(find_map("paper_lab", Path()))


def test_file_returns_the_last_stored_pose(tmp_path: Path, folder: MapFolder) -> None:
    file = PoseFile(tmp_path / "state" / "pose.json", "r1", folder)
    assert file.load() is None
    file.keep(msgspec.json.encode(msgspec.structs.replace(NOTED, x=9.0)))
    file.keep(msgspec.json.encode(NOTED))
    assert file.load() == NOTED
    assert [path.name for path in (tmp_path / "state").iterdir()] == ["pose.json"]
    file.keep(b"{}")
    file.keep(b"{}")
    assert file.load() is None
    assert file.failed == ""


def test_pose_of_another_robot_or_map_gives_none(tmp_path: Path, folder: MapFolder) -> None:
    path = tmp_path / "pose.json"
    PoseFile(path, "r1", folder).keep(msgspec.json.encode(NOTED))
    changed = replace(folder, files={**folder.files, "border.toml": b"# moved"})
    assert PoseFile(path, "r2", folder).load() is None
    assert PoseFile(path, "r1", changed).load() is None
    assert PoseFile(path, "r1", folder).load() == NOTED


@pytest.mark.parametrize("content", [b"", b"\xff\xfe", b'{"robot": "r1"}', b"[1, 2]"])
def test_damaged_file_sets_failed_and_gives_none(
    tmp_path: Path, folder: MapFolder, content: bytes
) -> None:
    path = tmp_path / "pose.json"
    path.write_bytes(content)
    file = PoseFile(path, "r1", folder)
    assert file.load() is None
    assert file.failed.startswith(f"{path}: no remembered pose: ")


def test_disk_error_sets_failed(tmp_path: Path, folder: MapFolder) -> None:
    (tmp_path / "not_a_folder").write_bytes(b"")
    file = PoseFile(tmp_path / "not_a_folder" / "pose.json", "r1", folder)
    file.keep(msgspec.json.encode(NOTED))
    assert "pose not kept" in file.failed


# --- the agent restarted ---------------------------------------------------------------------


def run_until(fleet: Fleet, t: float) -> list[Health]:
    """Return the health at every step."""
    healths = []
    while fleet.t < t:
        fleet.step()
        found = fleet.robots[0].agent.localizer.estimate
        if found is not None:
            healths.append(found.health)
    return healths


def patrolled(folder: MapFolder) -> tuple[Fleet, Tape]:
    tape = Tape()
    config = AgentConfig(memory=KEEPING)
    fleet = Fleet(folder, 1, seed=5, starts=[START], config=config, observer=lambda *_: tape)
    run_until(fleet, 10.0)
    return fleet, tape


def killed_run(folder: MapFolder) -> tuple[Fleet, RememberedPose]:
    """Patrol for a while, then kill the agent; the base's watchdog stops the robot."""
    fleet, tape = patrolled(folder)
    rig = fleet.robots[0].rig
    assert rig.base.velocity[0] > 0.1
    for _ in range(150):
        fleet.t = round(fleet.t + 0.02, 6)
        rig.advance(fleet.t)
        rig.base.pop_output(fleet.t)
        rig.laser.pop_output(fleet.t)
    assert rig.base.velocity == (0.0, 0.0)
    return fleet, last_note(tape)


def last_note(tape: Tape) -> RememberedPose:
    notes = [e for _, effects in tape.steps for e in effects if isinstance(e, Remember)]
    return msgspec.json.decode(notes[-1].payload, type=RememberedPose)


def restart(fleet: Fleet, folder: MapFolder, remembered: RememberedPose) -> Tape:
    """Start another agent without a start pose on the same robot."""
    robot, tape = fleet.robots[0], Tape()
    config = msgspec.structs.replace(robot.agent.config, start=None, remembered=remembered)
    devices = {"base": robot.rig.base, "laser": robot.rig.laser}
    lockstep = LockstepAgent(Agent(config, folder), devices, tape)  # type: ignore[arg-type]
    fleet.robots[0] = replace(robot, lockstep=lockstep)
    lockstep.start(fleet.t)
    return tape


def error(fleet: Fleet) -> float:
    robot = fleet.robots[0]
    found, truth = robot.agent.localizer.estimate, robot.rig.body.pose
    assert found is not None
    return math.hypot(found.pose.x - truth.x, found.pose.y - truth.y)


def test_restarted_agent_starts_from_the_stored_pose_and_replays(folder: MapFolder) -> None:
    fleet, remembered = killed_run(folder)
    tape = restart(fleet, folder, remembered)
    healths = run_until(fleet, fleet.t + 8.0)
    assert "starts from the remembered pose" in tape.news()
    assert healths[0] is Health.UNSURE, "the scans must confirm it"
    assert Health.LOST not in healths
    assert healths[-1] is Health.LOCALIZED
    assert error(fleet) < 0.1

    recorded = format_config(fleet.robots[0].agent.config).encode()
    again = Agent(parse_config(recorded, "recording"), folder)
    for event, effects in tape.steps:
        assert again.handle(event) == effects


def test_with_a_reset_odometer_the_agent_searches_globally(folder: MapFolder) -> None:
    """After a normal end of the agent the base counts from zero in the next session."""
    fleet, tape = patrolled(folder)
    fleet.shut_down()
    at_the_end = last_note(tape)
    assert tape.steps[-1][1][0] == Remember(msgspec.json.encode(at_the_end))
    tape = restart(fleet, folder, at_the_end)
    healths = run_until(fleet, fleet.t + 5.0)
    assert any("not believed" in words for words in tape.news())
    assert healths[0] is Health.LOST


def test_carried_robot_is_not_localized_at_the_stored_pose(
    folder: MapFolder,
) -> None:
    """The wheels were off the floor: the odometer continues, the scans do not fit."""
    fleet, remembered = killed_run(folder)
    fleet.robots[0].rig.body.pose = Pose(9.0, 5.0, -2.0)
    tape = restart(fleet, folder, remembered)
    assert "starts from the remembered pose" not in tape.news()
    for _ in range(160):
        healths = run_until(fleet, fleet.t + 0.05)
        if healths and healths[-1] is Health.LOCALIZED:
            assert error(fleet) < 0.3
    assert "starts from the remembered pose" in tape.news()

"""A robot driven by keys: real agent, emulated devices, virtual time."""

from __future__ import annotations

import io
import math
from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np
import pytest

from maps.map_folder import load_map_folder
from maps.pose import Pose
from robot_agent.agent import Agent
from robot_agent.config import AgentConfig
from robot_agent.messages.events import OperatorKey
from robot_agent.motion.teleop import HOLD_S, Teleop, TeleopSettings
from robot_agent.recording.recording_writer import RecordingWriter
from robot_agent.recording.run_header import header_of_run
from tools.campaign.agent_stage import make_room
from tools.logs.recording import read_recording
from tools.mapping.blank_map import blank_map
from tools.replay.carmen_recording import RecordingObserver
from tools.replay.replay import Replay
from tools.simulation.lockstep import LockstepAgent
from tools.simulation.rig import RobotRig
from tools.simulation.robot_body import BodyKind
from tools.simulation.stranger import PERSON
from tools.simulation.world import World

STEP_S = 0.02


@dataclass
class Drive:
    """One robot in a room, and its agent."""

    rig: RobotRig
    lockstep: LockstepAgent
    world: World
    writer: RecordingWriter
    file: io.BytesIO
    t: float = 0.0

    def go_on(self, duration: float, key: tuple[int, int] | None = None) -> None:
        """Let time pass, a key held down meanwhile."""
        end, next_key = self.t + duration, self.t
        while self.t < end:
            self.t = round(self.t + STEP_S, 6)
            if key is not None and self.t >= next_key:
                self.lockstep.press(self.t, *key)
                next_key += 0.05
            self.rig.advance(self.t)
            self.lockstep.deliver(self.t)

    @property
    def pose(self) -> Pose:
        return self.rig.body.pose


def start(tmp_path: Path, *, enabled: bool = True, pose: Pose | None = None) -> Drive:
    make_room(tmp_path / "room")
    world = World(load_map_folder(tmp_path / "room").map, np.random.default_rng(1))
    rig = RobotRig("robot1", world, world.add_body(pose or Pose(1.6, 1.6, 0.0)), 0.0)
    config = msgspec.structs.replace(AgentConfig(), teleop=TeleopSettings(enabled=enabled))
    folder = blank_map()
    file = io.BytesIO()
    header = header_of_run(config, folder, source="bench", start_wall_ns=0)
    writer = RecordingWriter(file, header)
    lockstep = LockstepAgent(
        Agent(config, folder), {"base": rig.base, "laser": rig.laser}, RecordingObserver(writer)
    )
    lockstep.start(0.0)
    drive = Drive(rig, lockstep, world, writer, file)
    drive.go_on(4.0)
    return drive


def test_held_key_drives_slowly_and_a_released_one_stops(tmp_path: Path) -> None:
    drive = start(tmp_path)
    assert not drive.rig.base.motors_enabled, "nobody has asked for motion"
    begun = drive.pose
    drive.go_on(6.0, key=(1, 0))
    way = math.dist(begun[:2], drive.pose[:2])
    assert 0.5 < way < 6.0 * 0.15 + 0.05
    drive.go_on(HOLD_S + 0.6)
    stopped = drive.pose
    drive.go_on(1.0)
    assert math.dist(stopped[:2], drive.pose[:2]) < 0.005
    assert drive.world.contacts == 0


def test_any_other_key_stops_at_once(tmp_path: Path) -> None:
    drive = start(tmp_path)
    drive.go_on(4.0, key=(1, 0))
    drive.go_on(0.1, key=(0, 0))
    drive.go_on(0.7)
    assert abs(drive.rig.base.velocity[0]) < 0.005


def test_keys_turn_the_robot(tmp_path: Path) -> None:
    drive = start(tmp_path)
    drive.go_on(3.0, key=(0, 1))
    assert 0.5 < drive.pose.theta < 1.3
    drive.go_on(5.0, key=(0, -1))
    assert drive.pose.theta < 0.3


def test_robot_stops_before_a_wall(tmp_path: Path) -> None:
    drive = start(tmp_path, pose=Pose(6.0, 1.2, 0.0))
    drive.go_on(20.0, key=(1, 0))
    assert drive.world.contacts == 0
    assert abs(drive.rig.base.velocity[0]) < 0.005
    assert drive.pose.x < 7.9 - 0.21


def test_without_fresh_scans_robot_does_not_move(tmp_path: Path) -> None:
    drive = start(tmp_path)
    drive.rig.laser.power_off(drive.t)
    drive.go_on(1.0)
    begun = drive.pose
    drive.go_on(3.0, key=(1, 0))
    assert math.dist(begun[:2], drive.pose[:2]) < 0.005


def test_patrolling_agent_ignores_keys(tmp_path: Path) -> None:
    drive = start(tmp_path, enabled=False)
    begun = drive.pose
    drive.go_on(3.0, key=(1, 0))
    assert math.dist(begun[:2], drive.pose[:2]) < 0.005


def test_a_drive_replays_identically(tmp_path: Path) -> None:
    drive = start(tmp_path)
    drive.go_on(3.0, key=(1, 1))
    drive.lockstep.shut_down(drive.t)
    drive.writer.finish()
    (tmp_path / "drive.mcap").write_bytes(drive.file.getvalue())
    result = Replay(read_recording(tmp_path / "drive.mcap")).run()
    assert result.difference is None
    assert result.bytes_sent > 100


@pytest.mark.parametrize(
    ("age", "ahead", "left", "expected"),
    [
        (0.0, 1, 0, (0.15, 0.0)),
        (0.69, 1, -1, (0.15, -0.4)),
        (0.71, 1, 0, (0.0, 0.0)),
        (-0.01, 1, 0, (0.0, 0.0)),
        (0.0, -1, 0, (0.0, 0.0)),
        (0.0, 9, 9, (0.15, 0.4)),
    ],
)
def test_key_expires_after_hold_time_and_is_limited(
    age: float, ahead: int, left: int, expected: tuple[float, float]
) -> None:
    teleop = Teleop()
    teleop.press(OperatorKey(10.0, ahead, left))
    assert teleop.requested(10.0 + age) == expected


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_turn_beside_a_person_does_not_touch_them(tmp_path: Path, side: float) -> None:
    """A person leaves the laser's view before a rear corner that would reach them comes round."""
    drive = start(tmp_path)
    place = drive.pose.compose(Pose(0.30, side * 0.46, side * -0.3))
    drive.world.add_body(place, PERSON).kind = BodyKind.PERSON
    drive.go_on(1.0)
    drive.go_on(1.0, (0, int(side)))  # hardly any room to turn to him
    drive.go_on(6.0, (0, int(-side)))
    assert drive.world.contacts == 0
    turned = math.degrees(drive.pose.theta) * -side
    assert 30.0 < turned < 100.0, "as far as there is room"

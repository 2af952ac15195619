"""Recordings of an emulated robot that is driven by keys: squares, left round and right round."""

from __future__ import annotations

import math
from pathlib import Path

import msgspec
import numpy as np

from maps.map_folder import load_map_folder
from maps.pose import Pose
from robot_agent.agent import Agent
from robot_agent.config import AgentConfig, find_map
from robot_agent.motion.teleop import TeleopSettings
from robot_agent.recording.recording_writer import RecordingWriter
from robot_agent.recording.run_header import header_of_run
from tools.mapping.blank_map import blank_map
from tools.replay.carmen_recording import RecordingObserver
from tools.simulation.lockstep import LockstepAgent
from tools.simulation.rig import RobotRig, make_rigs
from tools.simulation.truth.truth import load_truth
from tools.simulation.world import World

STEP_S = 0.02
START = Pose(5.0, 13.4, -1.2)
CORNERS = (1, 1, 1, 1, -1, -1, -1, -1)
_SIDE_S, _CORNER_S = 8.0, 4.3


def record_drive(
    folder: Path,
    truth: Path | str,
    *,
    wheel_scales: tuple[float, float] = (1.0, 1.0),
    config: AgentConfig | None = None,
    corners: tuple[int, ...] = CORNERS,
) -> Path:
    """Record a robot that really is as truth says; return the file.

    wheel_scales: counted over true way of left and right wheel. corners: 1 left, -1 right.
    """
    real = load_truth(str(truth))
    world = World(
        load_map_folder(find_map("paper_lab", Path())).map, np.random.default_rng(1), real.noise
    )
    [rig] = make_rigs(world, [START], 0.0, real)
    rig.body.wheel_scales = wheel_scales
    config = msgspec.structs.replace(config or AgentConfig(), teleop=TeleopSettings(enabled=True))
    path, blank = folder / "drive.mcap", blank_map()
    with path.open("wb") as file:
        writer = RecordingWriter(
            file, header_of_run(config, blank, source="bench", start_wall_ns=0)
        )
        lockstep = LockstepAgent(
            Agent(config, blank), {"base": rig.base, "laser": rig.laser}, RecordingObserver(writer)
        )
        lockstep.start(0.0)
        t = _go(rig, lockstep, 0.0, 4.0, (0, 0))
        for corner in corners:
            t = _go(rig, lockstep, t, _SIDE_S, (1, 0))
            t = _go(rig, lockstep, t, _CORNER_S, (0, corner))
        writer.finish()
    return path


def _go(
    rig: RobotRig, lockstep: LockstepAgent, t: float, duration: float, key: tuple[int, int]
) -> float:
    end = t + duration
    while t < end:
        t = round(t + STEP_S, 6)
        rig.advance(t)
        lockstep.deliver(t)
        lockstep.press(t, *key)
    return t


def truth_file(folder: Path, mount: Pose, *, upside_down: bool, slips: bool = False) -> Path:
    """Write a truth of a laser mounted so; without slips the wheels never slip."""
    path = folder / "truth.toml"
    text = f"""like = "plain"
about = "a test's"
[robot.laser]
x = {mount.x}
y = {mount.y}
theta = {math.remainder(mount.theta, math.tau)}
upside_down = {str(upside_down).lower()}
"""
    if not slips:
        names = ("slip_distance", "slip_rotation", "slip_heading", "odometer")
        text += "[noise]\n" + "".join(f"{name} = 0.0\n" for name in names)
    path.write_text(text)
    return path

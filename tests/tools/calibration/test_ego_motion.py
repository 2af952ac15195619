"""Motion of the laser by its scans alone, against the true one."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from drivers.p2os.model_choice import expected_model
from maps.border import Border
from maps.map_folder import load_map_folder
from maps.pose import Pose
from robot_agent.config import AgentConfig, find_map
from tools.calibration.drive import Drive
from tools.calibration.ego_motion import LaserMotion, laser_motions
from tools.simulation.rig import make_rigs
from tools.simulation.truth.truth import load_truth
from tools.simulation.world import World

BEAMS = 361
BEARINGS = np.radians(np.linspace(-90.0, 90.0, BEAMS))
STEP = 0.16  # m; a keyframe each
STEPS = 12
AWAY = 6.0  # m of border between two drives


def straight_starts(border: Border) -> list[Pose]:
    """Return poses from which the border goes straight on, and back, for all steps."""
    starts = []
    way = STEP * STEPS
    for s in np.arange(0.0, border.length, AWAY).tolist():
        here, there = border.at(s), border.at((s + way) % border.length)
        if math.hypot(there.x - here.x, there.y - here.y) > 0.999 * way:
            direction = math.atan2(here.ty, here.tx)
            starts.append(Pose(here.x, here.y, direction))
            starts.append(Pose(there.x, there.y, direction + math.pi))
    return starts


def motions_from(world: World, start: Pose) -> list[LaserMotion]:
    """Return the motions measured on a straight drive, with wheels that are right."""
    [rig] = make_rigs(world.twin(), [start], 0.0, load_truth("ideal"))
    poses = [start.compose(Pose(STEP * step, 0.0, 0.0)) for step in range(STEPS)]
    scans = [
        rig.world.scan(rig.body, pose, BEAMS, math.radians(0.5), (0.0, 0.0, 0.0)) for pose in poses
    ]
    config = AgentConfig()
    model = expected_model(config.base)
    drive = Drive(
        poses, [ends(scan) for scan in scans], np.empty(0), np.empty((0, 0)), config, model
    )
    return laser_motions(drive, lambda _: None)


def ends(ranges: NDArray[np.float64]) -> NDArray[np.float64]:
    points = np.column_stack((np.cos(BEARINGS), np.sin(BEARINGS))) * ranges[:, None]
    return np.asarray(points[np.isfinite(ranges)])


def test_motion_of_exact_scans_is_found_to_a_millimetre() -> None:
    folder = load_map_folder(find_map("paper_lab", Path()))
    assert folder.border is not None
    world = World(folder.map, np.random.default_rng(1), load_truth("ideal").noise)
    starts = straight_starts(folder.border)
    found = [motion for start in starts for motion in motions_from(world, start)]
    assert len(found) > 0.9 * len(starts) * (STEPS - 4)
    off = np.array([each.motion for each in found]) - (4 * STEP, 0.0, 0.0)
    assert np.abs(off.mean(axis=0)).max() < 0.0005  # m and rad
    assert off[:, 0].std() < 0.0011  # m; 1.4 mm by one of both ways alone

"""A robot at rest by its odometry keeps its pose: the estimate does not slide along the map."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from localization.health import Health
from localization.localizer import Localizer
from localization.settings import LocalizationSettings
from maps.map_folder import load_map_folder
from maps.pose import Pose
from tools.simulation.world import World

PAPER_LAB = Path(__file__).parents[2] / "maps" / "paper_lab"
INCREMENT = math.radians(0.5)
BEARINGS = (np.arange(361) - 180) * INCREMENT


@pytest.mark.parametrize(
    "pose",
    [
        Pose(9.9, 3.7, 0.25),  # in the south corridor
        Pose(
            14.62, 16.03, 0.88
        ),  # in a room; slid by 0.16 m with the surface behind the walls' faces
        Pose(14.48, 16.68, 0.31),
    ],
)
def test_pose_at_rest_does_not_slide(pose: Pose) -> None:
    occupancy = load_map_folder(PAPER_LAB).map
    world = World(occupancy, np.random.default_rng(1))
    body = world.add_body(pose)
    localizer = Localizer(LocalizationSettings(), occupancy, np.random.default_rng(2))
    localizer.start_at(pose, 0.05, 0.03)
    away = []
    for number in range(125):  # 25 s
        ranges = world.scan(body, pose, len(BEARINGS), INCREMENT, (0.0, 0.0, 0.0))
        hit = np.isfinite(ranges)
        unit = np.column_stack((np.cos(BEARINGS), np.sin(BEARINGS)))
        points = ranges[hit, None] * unit[hit]
        estimate = localizer.update(0.2 * number, Pose(0.0, 0.0, 0.0), points)
        away.append(math.hypot(estimate.pose.x - pose.x, estimate.pose.y - pose.y))
    assert estimate.health is Health.LOCALIZED
    assert max(away[10:]) < 0.02

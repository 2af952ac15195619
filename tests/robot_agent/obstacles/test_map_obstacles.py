"""Walls near the robot, from the map."""

import math

import numpy as np
import pytest

from maps.occupancy_map import FREE, OCCUPIED, OccupancyMap
from maps.pose import Pose
from robot_agent.motion.gate_limits import GateLimits
from robot_agent.motion.swept_footprint import SweptFootprint
from robot_agent.obstacles.map_obstacles import MapObstacles


@pytest.fixture(scope="module")
def walls() -> MapObstacles:
    """Free from 0 to 4 m both ways, walls round it."""
    cells = np.full((82, 82), FREE, dtype=np.uint8)
    cells[[0, -1], :] = OCCUPIED
    cells[:, [0, -1]] = OCCUPIED
    return MapObstacles(OccupancyMap(cells, 0.05, Pose(-0.05, -0.05, 0.0)), GateLimits())


def test_wall_nearby_is_at_its_distance(walls: MapObstacles) -> None:
    behind = walls.around(Pose(0.38, 2.0, 0.0))
    assert behind[:, 0].max() == pytest.approx(-0.38, abs=0.005)  # its surface
    ahead = walls.around(Pose(3.6, 2.0, 0.0))
    assert ahead[:, 0].min() == pytest.approx(0.40, abs=0.005)
    assert walls.around(Pose(2.0, 2.0, 0.0)).size == 0
    assert walls.around(Pose(-9.0, 2.0, 0.0)).size == 0


@pytest.mark.parametrize("heading", [0.0, 0.5, -2.0])
def test_turn_stops_before_a_corner_touches_the_wall(walls: MapObstacles, heading: float) -> None:
    # The robot stands along the wall at its right; its rear right corner would swing into it.
    pose = Pose(2.0, 0.30, 0.0)
    body = SweptFootprint(GateLimits())
    share = body.free_share(0.0, math.pi / 2, walls.around(pose))
    assert 0.0 < share < 0.5
    away = Pose(2.0, 0.60, heading)
    assert body.free_share(0.0, math.pi / 2, walls.around(away)) == 1.0


def test_map_points_inside_the_footprint_are_left_out(walls: MapObstacles) -> None:
    pose = Pose(0.25, 2.0, 0.0)  # its rear would be 5 cm deep in the wall
    points = walls.around(pose)
    assert not ((points[:, 0] > -0.24) & (np.abs(points[:, 1]) < 0.15)).any()

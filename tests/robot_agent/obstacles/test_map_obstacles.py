"""Walls near the robot, from the map."""

import math

import numpy as np
import pytest

from maps.occupancy_map import FREE, OCCUPIED, OccupancyMap
from maps.pose import Pose
from robot_agent.motion.gate_limits import GateLimits
from robot_agent.motion.swept_footprint import SweptFootprint
from robot_agent.obstacles.map_obstacles import POSITION_ERROR, MapObstacles


@pytest.fixture(scope="module")
def walls() -> MapObstacles:
    """Free from 0 to 4 m both ways, walls round it."""
    cells = np.full((82, 82), FREE, dtype=np.uint8)
    cells[[0, -1], :] = OCCUPIED
    cells[:, [0, -1]] = OCCUPIED
    return MapObstacles(OccupancyMap(cells, 0.05, Pose(-0.05, -0.05, 0.0)), GateLimits())


def around(walls: MapObstacles, pose: Pose) -> np.ndarray:
    """Return the obstacles with all walls where the map has them."""
    return walls.around(pose, np.empty(0, dtype=np.intp))


def test_wall_nearby_is_nearer_by_the_error_of_a_position(walls: MapObstacles) -> None:
    behind = around(walls, Pose(0.38, 2.0, 0.0))
    assert behind[:, 0].max() == pytest.approx(-0.38 + POSITION_ERROR, abs=0.005)  # its surface
    ahead = around(walls, Pose(3.6, 2.0, 0.0))
    assert ahead[:, 0].min() == pytest.approx(0.40 - POSITION_ERROR, abs=0.005)
    assert around(walls, Pose(2.0, 2.0, 0.0)).size == 0
    assert around(walls, Pose(-9.0, 2.0, 0.0)).size == 0


@pytest.mark.parametrize("heading", [0.0, 0.5, -2.0])
def test_turn_stops_before_a_corner_touches_the_wall(walls: MapObstacles, heading: float) -> None:
    # The robot stands along the wall at its right; its rear right corner would swing into it.
    pose = Pose(2.0, 0.30, 0.0)
    body = SweptFootprint(GateLimits())
    share = body.free_share(0.0, math.pi / 2, around(walls, pose))
    assert 0.0 < share < 0.5
    away = Pose(2.0, 0.60, heading)
    assert body.free_share(0.0, math.pi / 2, around(walls, away)) == 1.0


def test_map_points_inside_the_footprint_are_left_out(walls: MapObstacles) -> None:
    pose = Pose(0.25, 2.0, 0.0)  # its rear would be 5 cm deep in the wall
    points = around(walls, pose)
    assert not ((points[:, 0] > -0.24) & (np.abs(points[:, 1]) < 0.15)).any()


def test_wall_beside_the_robot_does_not_come_nearer_than_its_turn_margin(
    walls: MapObstacles,
) -> None:
    gate = GateLimits()
    for gap in (0.01, gate.turn_margin, gate.turn_margin + 0.005):
        points = around(walls, Pose(2.0, gate.half_width + gap, 0.0))
        nearest = np.abs(points[np.abs(points[:, 0]) < 0.2, 1]).min() - gate.half_width
        assert nearest == pytest.approx(min(gap, gate.turn_margin), abs=1e-6)


def test_all_walls_within_a_reach_are_returned(walls: MapObstacles) -> None:
    cells, points = walls.within(1.0, Pose(0.5, 2.0, 0.0))
    assert (np.diff(cells) > 0).all()
    assert points[:, 0].min() == pytest.approx(-0.5, abs=0.005)
    assert np.abs(points[:, 1]).max() == pytest.approx(1.0, abs=0.05)


def test_cells_that_are_gone_are_left_out(walls: MapObstacles) -> None:
    pose = Pose(0.38, 2.0, 0.0)
    cells, places = walls.within(1.0, pose)
    left = places[:, 1] > 0.0
    points = walls.around(pose, cells[left])
    assert len(points)
    assert points[:, 1].max() <= 0.0
    assert walls.around(pose, cells).size == 0

"""Start poses of simulated teams."""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np
import pytest

from maps.border import Border
from maps.border_primitives import Segment
from maps.occupancy_map import FREE, OCCUPIED, OccupancyMap
from maps.pose import Pose
from tools.simulation.start_poses import StartPoseError, free_start_poses


@pytest.fixture(scope="module")
def divided_hall() -> OccupancyMap:
    """20 x 8 m, divided by a wall along y = 5."""
    cells = np.full((160, 400), FREE, dtype=np.uint8)
    cells[[0, -1], :] = OCCUPIED
    cells[:, [0, -1]] = OCCUPIED
    cells[100, :] = OCCUPIED
    return OccupancyMap(cells=cells, resolution=0.05, origin=Pose(0.0, 0.0, 0.0))


@pytest.fixture(scope="module")
def border() -> Border:
    """A line along y = 3.5."""
    return Border([Segment((2.0, 3.5), (18.0, 3.5))], closed=False)


@pytest.mark.parametrize("seed", range(5))
def test_poses_are_clear_near_the_border_and_apart(
    divided_hall: OccupancyMap, border: Border, seed: int
) -> None:
    poses = free_start_poses(divided_hall, border, 4, np.random.default_rng(seed))
    assert len(poses) == 4
    for pose in poses:
        # Cells beyond the dividing wall are near enough, but have no path to the border.
        assert 0.05 + 0.5 <= pose.y <= 5.0 - 0.5
        assert 0.5 <= pose.x <= 19.5
        assert 1.0 <= border.project(pose.x, pose.y).distance <= 3.0
        assert -math.pi <= pose.theta <= math.pi
    for a, b in combinations(poses, 2):
        assert math.hypot(a.x - b.x, a.y - b.y) > 3.0


def test_poses_depend_on_the_seed_alone(divided_hall: OccupancyMap, border: Border) -> None:
    def poses(seed: int) -> list[Pose]:
        return free_start_poses(divided_hall, border, 3, np.random.default_rng(seed))

    assert poses(7) == poses(7)
    assert poses(7) != poses(8)


def test_many_robots_stand_closer_where_room_is_short(
    divided_hall: OccupancyMap, border: Border
) -> None:
    poses = free_start_poses(divided_hall, border, 12, np.random.default_rng(1))
    nearest = min(math.hypot(a.x - b.x, a.y - b.y) for a, b in combinations(poses, 2))
    assert 1.3 < nearest < 3.0


def test_too_many_robots_are_refused(divided_hall: OccupancyMap, border: Border) -> None:
    with pytest.raises(StartPoseError, match="no room for 60 robots"):
        free_start_poses(divided_hall, border, 60, np.random.default_rng(1))


def test_robots_that_reach_farther_stand_farther_from_walls_and_each_other(
    divided_hall: OccupancyMap, border: Border
) -> None:
    poses = free_start_poses(divided_hall, border, 3, np.random.default_rng(1), reach=0.9)
    for pose in poses:
        assert min(pose.x, 20.0 - pose.x, pose.y, abs(pose.y - 5.0)) > 0.9
    for a, b in combinations(poses, 2):
        assert math.dist(a[:2], b[:2]) > 1.8

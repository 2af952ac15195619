"""Starts beside walls."""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np
import pytest

from maps.border import Border
from maps.border_primitives import Segment
from maps.occupancy_map import FREE, OCCUPIED, OccupancyMap
from maps.pose import Pose
from tools.simulation.robot_body import Outline
from tools.simulation.start_poses import StartPoseError
from tools.simulation.tight_starts import GAP, tight_start_poses

OUTLINE = Outline()
BORDER = Border([Segment((1.0, 2.0), (9.0, 2.0))], closed=False)


def hall() -> OccupancyMap:
    """10 x 4 m with walls round it, and a post that a robot could stand on."""
    cells = np.full((80, 200), FREE, dtype=np.uint8)
    cells[[0, -1], :] = OCCUPIED
    cells[:, [0, -1]] = OCCUPIED
    cells[40, 100] = OCCUPIED
    return OccupancyMap(cells=cells, resolution=0.05, origin=Pose(0.0, 0.0, 0.0))


@pytest.mark.parametrize("seed", range(5))
def test_outline_is_beside_a_wall_and_on_none(seed: int) -> None:
    poses = tight_start_poses(hall(), BORDER, 3, np.random.default_rng(seed), OUTLINE)
    for pose in poses:
        c, s = math.cos(pose.theta), math.sin(pose.theta)
        corners = OUTLINE.perimeter(0.01) @ np.array(((c, s), (-s, c))) + (pose.x, pose.y)
        from_walls = np.minimum(corners - 0.05, (9.95, 3.95) - corners).min()
        from_post = np.maximum(np.abs(corners - (5.025, 2.025)) - 0.025, 0.0)
        gap = min(from_walls, np.hypot(*from_post.T).min())
        assert GAP[0] - 0.01 <= gap <= GAP[1]
        x, y = np.array(((c, s), (-s, c))) @ ((5.025, 2.025) - np.array(pose[:2]))
        assert not (-OUTLINE.rear < x < OUTLINE.front and abs(y) < OUTLINE.half_width)
    for a, b in combinations(poses, 2):
        assert math.hypot(a.x - b.x, a.y - b.y) > 1.5


def test_poses_depend_on_the_seed_alone() -> None:
    first, again, other = (
        tight_start_poses(hall(), BORDER, 2, np.random.default_rng(seed), OUTLINE)
        for seed in (7, 7, 8)
    )
    assert first == again != other


def test_more_robots_than_fit_are_refused() -> None:
    with pytest.raises(StartPoseError, match="beside walls for 40 robots"):
        tight_start_poses(hall(), BORDER, 40, np.random.default_rng(1), OUTLINE)

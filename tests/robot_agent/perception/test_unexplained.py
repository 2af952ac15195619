"""Points that the map explains, and those that it does not."""

from __future__ import annotations

import math

import numpy as np
import pytest

from maps.pose import Pose
from robot_agent.perception.settings import PerceptionSettings
from robot_agent.perception.unexplained import UnexplainedPoints
from tests.robot_agent.perception.simulated_room import Box, Room, shaken


@pytest.fixture
def unexplained(room: Room) -> UnexplainedPoints:
    return UnexplainedPoints(room.map, PerceptionSettings().detection_range)


def unexplained_in_map(
    unexplained: UnexplainedPoints, pose: Pose, points: list[tuple[float, float]]
) -> list[bool]:
    """Return the mask for points given in the map frame."""
    seen = np.array([pose.between(Pose(x, y, 0.0))[:2] for x, y in points])
    return unexplained.mask(pose, seen, np.hypot(seen[:, 0], seen[:, 1])).tolist()


def test_only_points_in_free_space_away_from_walls_are_unexplained(
    unexplained: UnexplainedPoints,
) -> None:
    pose = Pose(2.0, 2.0, 0.7)
    points = [
        (3.0, 2.5),  # free space
        (2.0, 0.1),  # near the wall
        (2.0, -0.5),  # unknown, behind the wall
        (1.0, -1.5),  # outside the map
        (-90.0, 2.0),
        (7.0, 2.0),  # free, but beyond the detection range
    ]
    assert unexplained_in_map(unexplained, pose, points) == [True] + [False] * 5


def test_the_distance_explained_grows_with_range(unexplained: UnexplainedPoints) -> None:
    from_wall = 0.21
    assert unexplained_in_map(unexplained, Pose(6.0, 1.0, 0.0), [(6.0, from_wall)]) == [True]
    assert unexplained_in_map(unexplained, Pose(6.0, 4.0, 0.0), [(6.0, from_wall)]) == [False]


def test_robot_is_unexplained_and_walls_are_not(unexplained: UnexplainedPoints, room: Room) -> None:
    rng = np.random.default_rng(1)
    pose = Pose(4.0, 4.0, 0.0)
    points = room.scan(pose, [Box(6.0, 4.0, 0.4)], rng)
    mask = unexplained.mask(pose, points, np.hypot(points[:, 0], points[:, 1]))
    assert np.hypot(*(points[mask] - (2.0, 0.0)).T).max() < 0.45
    assert 9 <= mask.sum() <= 22


def test_pose_errors_explain_away_nearly_every_wall_point(
    unexplained: UnexplainedPoints, room: Room
) -> None:
    rng = np.random.default_rng(2)
    wrong = total = 0
    for _ in range(300):
        pose = Pose(*rng.uniform((1.0, 1.0, -math.pi), (11.0, 7.0, math.pi)))
        points = room.scan(pose, [], rng)
        mask = unexplained.mask(shaken(pose, rng), points, np.hypot(points[:, 0], points[:, 1]))
        wrong += int(mask.sum())
        total += mask.size
    assert wrong / total < 2e-3

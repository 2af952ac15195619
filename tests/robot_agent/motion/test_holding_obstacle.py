"""Which obstacle holds the robot: the first in its way, with its source."""

import numpy as np
import pytest

from robot_agent.motion.gate_limits import GateLimits
from robot_agent.motion.holding_obstacle import HoldingObstacle, holding_obstacle
from robot_agent.motion.obstacle_points import NO_OBSTACLES, ObstaclePoints, ObstacleSource

LIMITS = GateLimits()
AHEAD = (0.35, 0.0)
LASER, SONAR, WALL = ObstacleSource.LASER, ObstacleSource.SONAR, ObstacleSource.MAP_WALL


def obstacles(*parts):
    return ObstaclePoints.joined([(source, np.array(points)) for source, points in parts])


@pytest.mark.parametrize("first", [0, 1, 2])
def test_first_obstacle_in_the_way_is_found_whatever_its_source(first):
    """Three in a row 0.5 to 0.7 m ahead, one beside, which is in nobody's way."""
    sources = [LASER, SONAR, WALL]
    distances = [0.7, 0.7, 0.7]
    distances[first] = 0.5
    parts = [
        (source, [(x, 0.05), (0.0, 1.5)]) for source, x in zip(sources, distances, strict=True)
    ]
    assert holding_obstacle(LIMITS, AHEAD, obstacles(*parts)) == HoldingObstacle(
        sources[first], 0.5, 0.05
    )


def test_on_the_spot_the_obstacle_beside_a_corner_holds():
    found = holding_obstacle(LIMITS, (0.0, 1.0), obstacles((WALL, [(-0.2, -0.26), (3.0, 0.0)])))
    assert found == HoldingObstacle(WALL, -0.2, -0.26)


def test_nothing_in_the_way_holds_nothing():
    assert holding_obstacle(LIMITS, AHEAD, NO_OBSTACLES) is None
    assert holding_obstacle(LIMITS, AHEAD, obstacles((LASER, [(0.0, 2.0)]))) is None


def test_source_of_an_index_beyond_all_points_is_refused():
    points = obstacles((LASER, [(1.0, 0.0)]), (SONAR, [(2.0, 0.0), (3.0, 0.0)]))
    assert [points.source_of(k) for k in range(3)] == [LASER, SONAR, SONAR]
    with pytest.raises(IndexError):
        points.source_of(3)

"""Ideal sight: range, field of view, occlusion, prediction."""

import math

import numpy as np
import pytest

from maps.occupancy_map import FREE, OCCUPIED, OccupancyMap
from maps.pose import Pose
from robot_agent.perception.settings import PerceptionSettings
from tools.bench.ideal_sight import IdealSight
from tools.simulation.robot_body import Outline

MIDDLE = Outline().middle  # of the body, ahead of base_link


def room(*walls: tuple[float, float]) -> OccupancyMap:
    """Return a room of 10 x 10 m whose only walls are cells at these places."""
    cells = np.full((200, 200), FREE, dtype=np.uint8)
    for x, y in walls:
        cells[int(y / 0.05), int(x / 0.05)] = OCCUPIED
    return OccupancyMap(cells, 0.05, Pose(0.0, 0.0, 0.0))


def look(sight: IdealSight, t: float, *poses: tuple[float, float, float], speed: float = 0.0):
    x, y, theta = np.array(poses).T
    heading = np.array((np.cos(theta), np.sin(theta)))
    base = np.array((x, y))
    return sight.look(t, base, heading, base + MIDDLE * heading, np.full(len(poses), speed))


def sight_of(occupancy: OccupancyMap, count: int = 2) -> IdealSight:
    return IdealSight(PerceptionSettings().detection_range, occupancy, count)


def test_body_ahead_within_visibility_is_at_its_centre():
    assert look(sight_of(room()), 0.0, (3.0, 5.0, 0.0), (5.4, 5.0, math.pi)) == [
        pytest.approx((5.4 - MIDDLE, 5.0)),
        pytest.approx((3.0 + MIDDLE, 5.0)),
    ]
    assert look(sight_of(room()), 0.0, (3.0, 5.0, 0.0), (5.6, 5.0, math.pi)) == [None, None]


def test_body_behind_is_not_in_view():
    seen = look(sight_of(room()), 0.0, (3.0, 5.0, math.pi), (5.0, 5.0, math.pi))
    assert seen == [None, pytest.approx((3.0 - MIDDLE, 5.0))]


@pytest.mark.parametrize(("field_of_view_deg", "seen"), [(180.0, False), (270.0, True)])
def test_body_aside_and_behind_is_in_view_of_a_wide_scanner(field_of_view_deg, seen):
    occupancy, reach = room(), PerceptionSettings().detection_range
    sight = IdealSight(reach, occupancy, 2, field_of_view_deg)
    behind = (3.0 - math.cos(math.radians(60.0)), 5.0 + math.sin(math.radians(60.0)), 0.0)
    assert (look(sight, 0.0, (3.0, 5.0, 0.0), behind)[0] is not None) is seen


@pytest.mark.parametrize("y", [5.0, 5.02])
def test_wall_of_one_cell_occludes(y):
    wall = room(*((4.0, row * 0.05 + 0.025) for row in range(60, 140)))
    assert look(sight_of(wall), 0.0, (3.0, y, 0.0), (5.0, y, math.pi)) == [None, None]


def test_body_occludes_what_is_behind_it():
    first, third = (3.0, 5.0, 0.0), (5.2, 5.0, math.pi)
    between = look(sight_of(room(), 3), 0.0, first, (4.1, 5.0, 0.0), third)
    assert between[0] == pytest.approx((4.1 + MIDDLE, 5.0))
    assert between[2] == pytest.approx((4.1 + MIDDLE, 5.0))
    sight = sight_of(room(), 3)
    look(sight, 0.0, first, (4.1, 5.0, 0.0), third)
    beside = look(sight, 10.0, first, (4.1, 9.0, math.pi / 2), third)
    assert beside[0] == pytest.approx((5.2 - MIDDLE, 5.0))


def test_teammate_out_of_view_is_predicted_for_a_limited_time():
    sight = sight_of(room())
    look(sight, 0.0, (3.0, 5.0, 0.0), (4.5, 5.0, math.pi / 2), speed=0.3)
    remembered, _ = look(sight, 1.0, (3.0, 5.0, math.pi), (9.0, 9.0, 0.0))
    way = 0.3 * (1.0 - math.exp(-1.0))
    assert remembered == pytest.approx((4.5, 5.0 + MIDDLE + way))
    assert look(sight, 3.1, (3.0, 5.0, math.pi), (9.0, 9.0, 0.0)) == [None, None]

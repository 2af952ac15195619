"""Segments sized against a Pioneer's outline."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest

from maps.pose import Pose
from robot_agent.perception.segments import Segment, find_segments
from robot_agent.perception.settings import PerceptionSettings
from robot_agent.perception.silhouette import Silhouettes, rectangle
from robot_agent.perception.unexplained import UnexplainedPoints
from tests.robot_agent.perception.simulated_room import SILHOUETTES, Box, Room

SETTINGS = PerceptionSettings()
CENTRE = Pose(6.0, 4.0, 0.0)


def segments_of(
    room: Room,
    boxes: Sequence[Box],
    rng: np.random.Generator,
    pose: Pose = CENTRE,
    increment: float = math.radians(1.0),
    silhouettes: Silhouettes = SILHOUETTES,
) -> list[Segment]:
    points = room.scan(pose, boxes, rng, increment)
    ranges = np.hypot(points[:, 0], points[:, 1])
    mask = UnexplainedPoints(room.map, SETTINGS.detection_range).mask(pose, points, ranges)
    return find_segments(silhouettes, points, ranges, mask)


def at(distance: float, bearing: float, theta: float, *size: float) -> Box:
    """Return a box at a distance and bearing from CENTRE."""
    return Box(
        CENTRE.x + distance * math.cos(bearing),
        CENTRE.y + distance * math.sin(bearing),
        theta,
        *size,
    )


@pytest.mark.parametrize("increment_deg", [0.5, 1.0])
@pytest.mark.parametrize("distance", [0.6, 1.0, 1.8, 2.5])
def test_a_robot_in_full_view_is_found_within_centimetres(
    room: Room, distance: float, increment_deg: float
) -> None:
    rng = np.random.default_rng(3)
    errors = []
    for _ in range(60):
        bearing, theta = rng.uniform(-1.0, 1.0), rng.uniform(-math.pi, math.pi)
        box = at(distance, bearing, theta)
        found = segments_of(room, [box], rng, increment=math.radians(increment_deg))
        assert len(found) == 1
        assert found[0].whole
        errors.append(math.hypot(found[0].x + CENTRE.x - box.x, found[0].y + CENTRE.y - box.y))
    assert np.median(errors) < 0.02
    assert np.percentile(errors, 95) < 0.05


def test_a_robot_beside_a_wall_is_found(room: Room) -> None:
    rng = np.random.default_rng(4)
    for theta in np.linspace(0.0, math.pi, 12):
        pose = Pose(6.0, 0.9, 0.0)
        found = segments_of(room, [Box(8.0, 0.7, float(theta))], rng, pose)
        assert len(found) == 1
        assert math.hypot(found[0].x - 2.0, found[0].y + 0.2) < 0.2


@pytest.mark.parametrize("size", [(0.12, 0.12), (0.2, 0.2), (1.2, 0.3), (1.0, 1.0)])
def test_other_sizes_are_not_robots(room: Room, size: tuple[float, float]) -> None:
    rng = np.random.default_rng(5)
    for distance in (1.2, 1.8, 2.5):
        found = segments_of(room, [at(distance, 0.3, math.pi / 2, *size)], rng)
        assert not any(each.whole and each.robot_sized and not each.small for each in found)


def test_a_pair_of_legs_is_not_a_robot(room: Room) -> None:
    rng = np.random.default_rng(6)
    for distance in (1.0, 1.7, 2.4):
        for apart in (0.12, 0.2, 0.3):
            legs = [
                Box(CENTRE.x + distance, CENTRE.y + side * (apart + 0.13) / 2, 0.2, 0.13, 0.13)
                for side in (-1, 1)
            ]
            found = segments_of(room, legs, rng)
            assert not any(each.whole and each.robot_sized for each in found)


def test_two_legs_a_stride_apart_are_one_person_between_them(room: Room) -> None:
    rng = np.random.default_rng(9)
    legs = [Box(CENTRE.x + 1.5, CENTRE.y + y, 0.2, 0.13, 0.13) for y in (-0.2, 0.2)]
    [person] = segments_of(room, legs, rng)
    assert person.whole
    assert not person.robot_sized
    assert math.hypot(person.x - 1.5, person.y) < 0.12


@pytest.mark.parametrize("side", [-1, 1])
def test_a_housing_beside_a_person_is_not_one_of_the_legs(room: Room, side: int) -> None:
    """Of three things within a stride of the next one the two closest are the person."""
    rng = np.random.default_rng(12)
    housing = Box(CENTRE.x + 1.5, CENTRE.y + side * 0.6, 0.0, 0.156, 0.155)
    legs = [Box(CENTRE.x + 1.5, CENTRE.y + side * y, 0.2, 0.12, 0.12) for y in (-0.15, 0.1)]
    found = segments_of(room, [*legs, housing], rng, increment=math.radians(0.5))
    [person] = [each for each in found if each.legs]
    assert math.hypot(person.x - 1.5, person.y + side * 0.025) < 0.12
    [robot] = [each for each in found if each.small and each.whole]
    assert math.hypot(robot.x - 1.5, robot.y - side * 0.6) < 0.05


@pytest.mark.parametrize("distance", [0.8, 1.5, 2.4])
def test_a_bare_scanner_housing_is_found_as_a_small_robot(room: Room, distance: float) -> None:
    rng = np.random.default_rng(10)
    errors = []
    for theta in rng.uniform(-math.pi, math.pi, 40).tolist():
        box = at(distance, 0.4, theta, 0.156, 0.155)
        found = segments_of(room, [box], rng, increment=math.radians(0.5))
        assert len(found) == 1
        if found[0].robot_sized:
            assert found[0].small
            errors.append(math.hypot(found[0].x + CENTRE.x - box.x, found[0].y + CENTRE.y - box.y))
    assert len(errors) > 35
    assert np.percentile(errors, 95) < 0.05


def test_whatever_is_as_wide_as_the_own_body_is_robot_sized_admitted_or_not(room: Room) -> None:
    rng = np.random.default_rng(11)
    housings = Silhouettes.admitted(["housing"], rectangle(0.51, 0.40))
    found = segments_of(room, [at(1.5, 0.0, 0.3)], rng, silhouettes=housings)
    assert [(each.robot_sized, each.small) for each in found] == [(True, False)]
    assert found[0].misfit == math.inf


def test_a_half_hidden_robot_is_found_about_where_it_is(room: Room) -> None:
    rng = np.random.default_rng(7)
    robot, pillar = at(2.0, 0.0, 0.0), Box(CENTRE.x + 1.0, CENTRE.y + 0.22, 0.0, 0.2, 0.4)
    found = segments_of(room, [robot, pillar], rng)
    [part] = [segment for segment in found if segment.x > 1.5]
    assert part.extent < 0.3
    assert not part.whole
    assert math.hypot(part.x - 2.0, part.y) < 0.1
    assert 0.02 < math.sqrt(part.var_y) < 0.15


def test_segments_are_sorted_by_distance(room: Room) -> None:
    rng = np.random.default_rng(8)
    found = segments_of(room, [at(2.4, -0.7, 0.0), at(1.2, 0.4, 1.0)], rng)
    assert [round(math.hypot(segment.x, segment.y), 1) for segment in found] == [1.2, 2.4]


def test_no_points_give_no_segments() -> None:
    nothing = np.empty((0, 2))
    assert find_segments(SILHOUETTES, nothing, np.empty(0), np.empty(0, dtype=bool)) == []

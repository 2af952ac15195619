"""People and teammates round the robot do not move its pose: their beams are left out."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from localization.health import Health
from localization.localizer import Localizer
from localization.settings import LocalizationSettings
from maps.pose import Pose
from robot_agent.perception.identity import Kind
from robot_agent.perception.settings import PerceptionSettings
from robot_agent.perception.tracker import TeammateTracker
from tests.robot_agent.perception.simulated_room import SILHOUETTES, Box, Room

PERIOD = 0.1  # s


def own(t: float) -> Pose:
    """Drive at 0.35 m/s on a circle of 1.3 m."""
    angle = t * 0.35 / 1.3
    return Pose(6.0 + 1.3 * math.cos(angle), 4.0 + 1.3 * math.sin(angle), angle + math.pi / 2)


def people(t: float) -> list[Box]:
    """Four people who walk with the robot, half a metre to a metre away on all sides."""
    here, boxes = own(t), []
    for number in range(4):
        bearing = number * math.pi / 2 + 0.5 + 0.4 * math.sin(0.7 * t + number)
        distance = 0.8 + 0.3 * math.sin(0.5 * t + 2.0 * number)
        place = here.compose(Pose(distance * math.cos(bearing), distance * math.sin(bearing), 0))
        boxes.append(Box(place.x, place.y, place.theta, length=0.3, width=0.4))
    return boxes


@pytest.mark.parametrize("tracked", [False, True])
def test_four_people_round_the_robot_do_not_move_the_pose(room: Room, tracked: bool) -> None:
    rng = np.random.default_rng(1)
    localizer = Localizer(LocalizationSettings(), room.map, np.random.default_rng(2))
    tracker = TeammateTracker(PerceptionSettings(), room.map, SILHOUETTES)
    localizer.start_at(own(0.0), 0.05, 0.02)
    left_out = 0
    for step in range(200):
        t = step * PERIOD
        truth = own(t)
        odometry = Pose(50.0, 3.0, 1.0).compose(own(0.0).between(truth))
        points = room.scan(truth, people(t) if t > 2.0 else [], rng)
        last, ignore = localizer.estimate, None
        if tracked and last is not None and last.health is Health.LOCALIZED:
            ignore = tracker.covered(t, last.pose_at(odometry), points)
            left_out += 0 if ignore is None else int(np.count_nonzero(ignore))
        estimate = localizer.update(t, odometry, points, ignore)
        tracker.update(t, estimate.pose, points)
        assert math.hypot(estimate.pose.x - truth.x, estimate.pose.y - truth.y) < 0.05, t
        assert t < 2.0 or estimate.health is Health.LOCALIZED
    assert not tracked or left_out > 200 * 20


def test_beams_on_a_track_are_covered_and_no_others(room: Room) -> None:
    rng = np.random.default_rng(3)
    tracker = TeammateTracker(PerceptionSettings(), room.map, SILHOUETTES)
    pose, robot = Pose(3.0, 4.0, 0.0), Box(4.5, 4.0, 0.0)
    for step in range(10):
        points = room.scan(pose, [robot], rng)
        tracker.update(step * PERIOD, pose, points)
    covered = tracker.covered(0.9, pose, points)
    assert covered is not None
    on_robot = np.linalg.norm(points - (1.5, 0.0), axis=1) < 0.4
    assert np.array_equal(covered, on_robot)
    assert 10 < np.count_nonzero(covered) < 40
    forgotten = tracker.covered(2.0, pose, points)
    assert forgotten is not None
    assert not forgotten.any()


def test_covered_is_none_for_a_scan_mostly_on_tracks(room: Room) -> None:
    rng = np.random.default_rng(3)
    tracker = TeammateTracker(PerceptionSettings(), room.map, SILHOUETTES, max_covered=0.05)
    pose = Pose(3.0, 4.0, 0.0)
    for step in range(10):
        points = room.scan(pose, [Box(4.5, 4.0, 0.0)], rng)
        tracker.update(step * PERIOD, pose, points)
    assert tracker.covered(0.9, pose, points) is None


def _legs_in_line(bearing: float) -> list[Box]:
    """Return two legs 0.3 m apart, 1.6 m ahead of (3, 4), on a line at this bearing, rad."""
    x, y = 0.15 * math.cos(bearing), 0.15 * math.sin(bearing)
    return [Box(4.6 + side * x, 4.0 + side * y, 0.0, 0.12, 0.12) for side in (-1, 1)]


def test_legs_that_stand_are_a_person_also_when_one_comes_to_hide_the_other(room: Room) -> None:
    rng = np.random.default_rng(4)
    tracker = TeammateTracker(PerceptionSettings(), room.map, SILHOUETTES)
    pose = Pose(3.0, 4.0, 0.0)
    for step in range(20):
        legs = _legs_in_line(math.pi / 2 if step < 10 else 0.0)
        tracker.update(step * PERIOD, pose, room.scan(pose, legs, rng))
    [track] = tracker.tracks
    assert not track.moving
    assert track.person_like


def test_legs_that_looked_like_a_housing_from_afar_are_a_person_unless_they_wear_the_band(
    room: Room,
) -> None:
    """Else the robot turned its rear corner into a person whom pictures had told from a robot."""
    rng = np.random.default_rng(4)
    tracker = TeammateTracker(PerceptionSettings(), room.map, SILHOUETTES)
    pose = Pose(3.0, 4.0, 0.0)
    for step in range(20):
        legs = _legs_in_line(math.pi / 2 if step > 15 else 0.0)
        tracker.update(step * PERIOD, pose, room.scan(pose, legs, rng))
    [track] = tracker.tracks
    assert track.legs
    seen_as_housing = replace(track, robot_sized=True, small=False, by_color=True)
    assert replace(seen_as_housing, kind=Kind.STRANGER).person_like
    assert not replace(seen_as_housing, kind=Kind.TEAMMATE).person_like


@pytest.mark.parametrize("size", [(0.511, 0.425), (0.155, 0.156), (0.12, 0.12)])
def test_one_thing_that_stands_is_no_person(room: Room, size: tuple[float, float]) -> None:
    rng = np.random.default_rng(5)
    tracker = TeammateTracker(PerceptionSettings(), room.map, SILHOUETTES)
    pose = Pose(3.0, 4.0, 0.0)
    for step in range(20):
        points = room.scan(pose, [Box(4.6, 4.0, 0.3, *size)], rng)
        tracker.update(step * PERIOD, pose, points)
    assert not any(track.person_like for track in tracker.tracks)

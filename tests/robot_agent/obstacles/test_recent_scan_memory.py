"""Points beside the robot are kept when they leave the laser's view."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from maps.pose import Pose
from robot_agent.motion.gate_limits import GateLimits
from robot_agent.motion.swept_footprint import SweptFootprint
from robot_agent.obstacles.recent_scan_memory import MEMORY, RecentScanMemory
from robot_agent.perception.scan_points import move_points

GATE = GateLimits()
START = Pose(3.0, -1.0, 0.7)


def in_view(points: NDArray[np.float64]) -> NDArray[np.bool_]:
    return np.asarray(points[:, 0] >= 0.0)


def turned(degrees: float) -> Pose:
    return START.compose(Pose(0.0, 0.0, math.radians(degrees)))


def test_turn_stops_before_a_rear_corner_touches_a_person_beside() -> None:
    """A person beside the left front corner leaves the laser's view as the robot turns."""
    left, body = RecentScanMemory(GATE), SweptFootprint(GATE)
    person = move_points(np.array([(0.10, 0.31), (0.02, 0.31), (0.20, 0.33)]), START)
    reached = 0.0
    for k, degrees in enumerate(np.arange(0.0, -120.0, -3.0).tolist()):
        pose = turned(degrees)
        # The scan before showed what was ahead three degrees earlier.
        before = turned(degrees + 3.0)
        points = move_points(person, before.between(Pose(0.0, 0.0, 0.0)))
        seen = move_points(points[in_view(points)], pose.between(before))
        left.update(0.1 * k, pose, seen, in_view)
        known = np.concatenate((left.around(pose), seen[in_view(seen)]))
        if body.free_share(0.0, math.radians(-3.0), known) < 1.0:
            break
        reached = degrees
    corner = move_points(person, turned(reached).between(Pose(0.0, 0.0, 0.0)))
    in_body = (np.abs(corner[:, 1]) < GATE.half_width) & (corner[:, 0] > -GATE.rear)
    assert not in_body.any()
    assert -80.0 < reached < -30.0, "it turns as far as there is room"


def test_points_back_in_view_are_dropped() -> None:
    left = RecentScanMemory(GATE)
    someone = move_points(np.array([(0.05, 0.4)]), START)
    seen = move_points(someone, turned(-20.0).between(Pose(0.0, 0.0, 0.0)))
    left.update(0.1, turned(-20.0), seen, in_view)
    [[x, y]] = left.around(turned(-20.0))
    assert math.hypot(x, y) == pytest.approx(math.hypot(0.05, 0.4))
    assert x < 0.0
    left.update(0.2, turned(5.0), np.empty((0, 2)), in_view)
    assert left.around(turned(-20.0)).size == 0, "it has gone meanwhile"


def test_old_far_and_touching_points_are_dropped() -> None:
    left = RecentScanMemory(GATE)
    touching, near, far = (-0.1, 0.22), (-0.1, 0.4), (-0.1, 0.8)
    left.update(1.0, START, np.array([touching, near, far]), in_view)
    assert left.around(START) == pytest.approx(np.array([near]))
    left.update(1.0 + MEMORY, START, np.empty((0, 2)), in_view)
    assert len(left.around(START)) == 1
    ahead = START.compose(Pose(0.5, 0.0, 0.0))
    left.update(1.1 + MEMORY, START, np.empty((0, 2)), in_view)
    assert len(left.around(START)) == 0
    left.update(9.0, START, np.array([near]), in_view)
    left.update(9.1, ahead, np.empty((0, 2)), in_view)
    assert len(left.around(ahead)) == 0


def test_without_a_pose_points_do_not_expire() -> None:
    """Without a pose the map's walls are missing, and the recovery turn would touch one."""
    left = RecentScanMemory(GATE)
    left.lasts = True
    left.update(1.0, START, np.array([(-0.1, 0.4)]), in_view)
    left.update(99.0, START, np.empty((0, 2)), in_view)
    assert len(left.around(START)) == 1
    left.lasts = False
    left.update(99.1, START, np.empty((0, 2)), in_view)
    assert len(left.around(START)) == 0

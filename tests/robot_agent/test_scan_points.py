"""Scans become points in base_link; an asymmetric scene tells mirrored and turned geometry."""

import math

import numpy as np
import pytest

from drivers.lms200.scan import Scan
from maps.pose import Pose
from robot_agent.obstacles import REACH, Obstacles
from robot_agent.scan_points import ScanProjector, move_points


def scan_of(ranges: list[float], increment: float = math.pi / 2) -> Scan:
    return Scan(
        t=0.0,
        angle_min=-math.pi / 2,
        angle_increment=increment,
        ranges=np.array(ranges),
        status=0x10,
        turns=1,
        specials=np.zeros(len(ranges), np.uint8),
        flags=np.zeros(len(ranges), np.uint8),
        reflectors=None,
    )


def test_right_ahead_left_are_where_rep_103_says() -> None:
    points = ScanProjector(Pose(0.0, 0.0, 0.0)).points(scan_of([1.0, 2.0, 3.0]))
    assert points == pytest.approx(np.array([(0.0, -1.0), (2.0, 0.0), (0.0, 3.0)]))


def test_the_mount_moves_and_turns_the_points() -> None:
    points = ScanProjector(Pose(0.1, 0.2, math.pi / 2)).points(scan_of([1.0, 2.0, 3.0]))
    assert points == pytest.approx(np.array([(1.1, 0.2), (0.1, 2.2), (-2.9, 0.2)]))


def test_beams_without_return_are_left_out() -> None:
    projector = ScanProjector(Pose(0.0, 0.0, 0.0))
    assert projector.points(scan_of([math.inf, 2.0, math.inf])) == pytest.approx(
        np.array([(2.0, 0.0)])
    )
    assert projector.points(scan_of([math.inf] * 3)).shape == (0, 2)


def test_a_change_of_geometry_is_followed() -> None:
    projector = ScanProjector(Pose(0.0, 0.0, 0.0))
    projector.points(scan_of([1.0, 1.0, 1.0]))
    finer = projector.points(scan_of([1.0] * 5, math.pi / 4))
    assert finer[1] == pytest.approx((math.sqrt(0.5), -math.sqrt(0.5)))


def test_points_move_with_their_frame() -> None:
    moved = move_points(np.array([(1.0, 0.0)]), Pose(2.0, 3.0, math.pi / 2))
    assert moved == pytest.approx(np.array([(2.0, 4.0)]))


def test_obstacles_come_nearer_as_the_robot_drives_on() -> None:
    obstacles = Obstacles()
    assert obstacles.seen_at is None
    obstacles.see(1.0, Pose(0.0, 0.0, 0.0), np.array([(1.0, 0.0), (REACH + 1.0, 0.0)]))
    assert obstacles.seen_at == 1.0
    around = obstacles.around(Pose(0.4, 0.0, math.pi / 2))
    assert around == pytest.approx(np.array([(0.0, -0.6)])), "the far point is dropped"

"""The footprint of the robot's body."""

import numpy as np
import pytest

from robot_agent.motion.footprint import Footprint
from robot_agent.motion.gate_limits import GateLimits

GATE = GateLimits(front=0.2, rear=0.3, half_width=0.4)
FOOTPRINT = Footprint(GATE)
CORNERS = np.array([(0.2, 0.4), (0.2, -0.4), (-0.3, 0.4), (-0.3, -0.4)])


def test_points_on_the_edge_are_not_covered():
    assert not FOOTPRINT.covers(CORNERS).any()
    assert FOOTPRINT.covers(CORNERS * 0.99).all()


def test_margin_grows_the_footprint_on_all_sides():
    beside = np.array([(0.24, 0.0), (-0.34, 0.0), (0.0, 0.44), (0.0, -0.44)])
    assert not FOOTPRINT.covers(beside).any()
    assert FOOTPRINT.covers(beside, margin=0.05).all()


def test_corner_reach_is_the_distance_of_the_farthest_corner():
    assert FOOTPRINT.corner_reach == pytest.approx(np.hypot(*CORNERS.T).max())


def test_points_come_nearer_by_an_error_but_not_into_a_margin() -> None:
    limits = GateLimits()
    front, side = limits.front, limits.half_width
    points = np.array([(front + 0.1, 0.0), (0.0, side + 0.03), (0.0, -side - 0.01), (0.0, 0.0)])
    nearer = Footprint(limits).nearer(points, 0.015, 0.02)
    assert nearer == pytest.approx(
        np.array([(front + 0.085, 0.0), (0.0, side + 0.02), (0.0, -side - 0.01), (0.0, 0.0)])
    )
    corner = np.array([(front + 0.03, side + 0.04)])  # 0.05 m from the body's corner
    (moved,) = Footprint(limits).nearer(corner, 0.015, 0.02)
    assert np.hypot(*(moved - (front, side))) == pytest.approx(0.035)

"""Where the robot's own body is."""

import numpy as np
import pytest

from robot_agent.motion.footprint import corner_reach, in_body
from robot_agent.motion.gate_limits import GateLimits

GATE = GateLimits(front=0.2, rear=0.3, half_width=0.4)
CORNERS = np.array([(0.2, 0.4), (0.2, -0.4), (-0.3, 0.4), (-0.3, -0.4)])


def test_what_is_on_its_rim_is_not_in_the_body():
    assert not in_body(CORNERS, GATE).any()
    assert in_body(CORNERS * 0.99, GATE).all()


def test_a_margin_goes_all_round_it():
    beside = np.array([(0.24, 0.0), (-0.34, 0.0), (0.0, 0.44), (0.0, -0.44)])
    assert not in_body(beside, GATE).any()
    assert in_body(beside, GATE, margin=0.05).all()


def test_the_farthest_corner_is_its_reach():
    assert corner_reach(GATE) == pytest.approx(np.hypot(*CORNERS.T).max())

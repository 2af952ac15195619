"""Each elementary behavior against its equation."""

import math

import numpy as np
import pytest

from maps.border import Border
from maps.border_primitives import Segment
from robot_agent.patrol.behaviors import (
    patrol_clockwise,
    patrol_counter_clockwise,
    patrol_onward,
    reach_frontier,
    teammate_avoidance,
)

BORDER = Border([Segment((0.0, 0.0), (10.0, 0.0))], closed=False)  # +s is +x, left is +y


def reach(x, y, *, beyond_end=False):
    foot = BORDER.project(x, y)
    return reach_frontier((x, y), foot, gain=0.3, speed_limit=0.5, beyond_end=beyond_end)


def test_reach_frontier_is_equation_6():
    task = reach(4.0, -1.0)
    assert task.velocity == pytest.approx([0.0, 0.3])
    assert task.jacobian == pytest.approx(np.array([[0.0, -1.0]]))


def test_reach_frontier_is_no_faster_than_its_limit():
    assert reach(4.0, 1.6).velocity == pytest.approx([0.0, -0.48])
    assert reach(4.0, 30.0).velocity == pytest.approx([0.0, -0.5])


@pytest.mark.parametrize("y", [0.0, 1e-300, 0.9e-3, -0.9e-3])
def test_reach_frontier_on_the_border_uses_the_normal(y):
    task = reach(4.0, y)
    assert task.velocity == pytest.approx([0.0, 0.0])
    assert task.jacobian == pytest.approx(np.array([[0.0, 1.0]]))


def test_reach_frontier_just_off_the_border_heads_for_it():
    assert reach(4.0, 1.1e-3).velocity == pytest.approx([0.0, -0.33e-3])


def test_reach_frontier_beyond_an_end_leaves_the_way_back_free():
    task = reach(-0.4, 0.3, beyond_end=True)
    assert task.velocity == pytest.approx([0.12, -0.09])
    assert task.jacobian == pytest.approx(np.array([[0.0, 1.0]]))


def test_patrol_both_ways_is_equation_7():
    foot = BORDER.project(4.0, 0.2)
    assert patrol_clockwise(foot, speed=0.35).velocity == pytest.approx([0.35, 0.0])
    assert patrol_counter_clockwise(foot, speed=0.35).velocity == pytest.approx([-0.35, 0.0])
    assert patrol_onward(foot, 1, speed=0.35).velocity == pytest.approx([0.35, 0.0])
    assert patrol_onward(foot, -1, speed=0.35).velocity == pytest.approx([-0.35, 0.0])
    assert patrol_onward(foot, -1, speed=0.35).jacobian == pytest.approx(np.array([[1.0, 0.0]]))


def avoid(position, teammate):
    return teammate_avoidance(
        position,
        teammate,
        gain=0.3,
        safety_distance=2.4,
        speed_limit=0.3,
        fallback=(0.0, 1.0),
    )


def test_teammate_avoidance_is_equation_8():
    task = avoid((0.0, 0.0), (1.2, 1.6))  # 2 m away
    assert task.velocity == pytest.approx([-0.12 * 0.6, -0.12 * 0.8])
    assert task.jacobian == pytest.approx(np.array([[-0.6, -0.8]]))


def test_teammate_avoidance_reaches_the_printed_speed_at_1_4_m():
    assert math.hypot(*avoid((0.0, 0.0), (1.4, 0.0)).velocity) == pytest.approx(0.3)
    assert math.hypot(*avoid((0.0, 0.0), (0.5, 0.0)).velocity) == pytest.approx(0.3)


def test_teammate_avoidance_never_attracts():
    assert avoid((0.0, 0.0), (2.6, 0.0)).velocity == pytest.approx([0.0, 0.0])


def test_teammate_avoidance_at_equal_positions_uses_the_fallback():
    assert avoid((1.0, 1.0), (1.0, 1.0)).velocity == pytest.approx([0.0, 0.3])

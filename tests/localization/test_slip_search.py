"""The search back along a step: finds where slipping wheels left the robot, and nothing else."""

from __future__ import annotations

import math

import numpy as np
import pytest

from localization.likelihood_field import LikelihoodField
from localization.refinement import Refinement
from localization.settings import LocalizationSettings
from localization.slip_search import MIN_GAIN, SlipSearch
from maps.pose import Pose

TRUTH = Pose(9.0, 1.0, 0.02)
STEP = Pose(1.4, 0.0, 0.0)


def search(room, min_gain: float = MIN_GAIN) -> SlipSearch:
    field = LikelihoodField(room.map, LocalizationSettings().beams)
    return SlipSearch(field, Refinement(room.map), min_gain=min_gain)


@pytest.mark.parametrize("lost", [0.15, 0.3, 0.45])
@pytest.mark.parametrize("seed", range(4))
def test_finds_where_the_wheels_slipped_to(corridor, lost: float, seed: int) -> None:
    points = corridor.scan(TRUTH, np.random.default_rng(seed))
    counted = TRUTH.compose(Pose(lost * STEP.x, 0.01, 0.0))
    refined = search(corridor).find(counted, STEP, points)
    assert refined is not None
    assert math.hypot(refined.pose.x - TRUTH.x, refined.pose.y - TRUTH.y) < 0.06
    assert abs(refined.pose.theta - TRUTH.theta) < math.radians(1.0)


@pytest.mark.parametrize("seed", range(10))
def test_leaves_a_good_pose_alone(corridor, seed: int) -> None:
    points = corridor.scan(TRUTH, np.random.default_rng(seed))
    assert search(corridor).find(TRUTH, STEP, points) is None


def test_looks_ahead_where_the_robot_drove_backwards(corridor) -> None:
    points = corridor.scan(TRUTH, np.random.default_rng(1))
    counted = TRUTH.compose(Pose(-0.4, 0.0, 0.0))
    assert search(corridor).find(counted, STEP, points) is None
    refined = search(corridor).find(counted, Pose(-1.4, 0.0, 0.0), points)
    assert refined is not None
    assert refined.pose.x == pytest.approx(TRUTH.x, abs=0.06)


def test_a_step_too_short_to_slip_far_is_not_looked_at(corridor) -> None:
    points = corridor.scan(TRUTH, np.random.default_rng(1))
    counted = TRUTH.compose(Pose(0.4, 0.0, 0.0))
    assert search(corridor).find(counted, Pose(0.19, 0.0, 0.0), points) is None
    assert search(corridor).find(counted, Pose(1.4, 0.0, 0.0), points) is not None


def test_bare_walls_that_tell_nothing_move_nothing(corridor) -> None:
    """Only beams to the sides: the same anywhere along the corridor."""
    points = corridor.scan(TRUTH, np.random.default_rng(1))
    sides = points[np.abs(points[:, 0]) < 3.0]
    counted = TRUTH.compose(Pose(0.4, 0.0, 0.0))
    assert search(corridor).find(counted, STEP, sides) is None


def test_a_higher_gain_asks_for_more(corridor) -> None:
    points = corridor.scan(TRUTH, np.random.default_rng(1))
    counted = TRUTH.compose(Pose(0.4, 0.0, 0.0))
    assert search(corridor, min_gain=1e3).find(counted, STEP, points) is None
    assert search(corridor).find(counted, STEP, points[:3]) is None

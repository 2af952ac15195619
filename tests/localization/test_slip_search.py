"""The slip search: finds the pose where slipping wheels left the robot, and no other."""

from __future__ import annotations

import math

import numpy as np
import pytest

from localization.matching import Matching
from localization.settings import LocalizationSettings
from localization.slip_search import MIN_GAIN, SlipSearch
from maps.pose import Pose

TRUTH = Pose(9.0, 1.0, 0.02)
STEP = Pose(1.4, 0.0, 0.0)


def search(room, min_gain: float = MIN_GAIN) -> SlipSearch:
    return SlipSearch(Matching(room.map, LocalizationSettings().beams), min_gain=min_gain)


@pytest.mark.parametrize("lost", [0.15, 0.3, 0.45])
@pytest.mark.parametrize("seed", range(4))
def test_pose_after_slip_is_found(corridor, lost: float, seed: int) -> None:
    points = corridor.scan(TRUTH, np.random.default_rng(seed))
    counted = TRUTH.compose(Pose(lost * STEP.x, 0.01, 0.0))
    slipped = search(corridor).find(counted, STEP, points)
    assert slipped is not None
    assert slipped.certain
    refined = slipped.refined
    assert math.hypot(refined.pose.x - TRUTH.x, refined.pose.y - TRUTH.y) < 0.06
    assert abs(refined.pose.theta - TRUTH.theta) < math.radians(1.0)


@pytest.mark.parametrize("seed", range(10))
def test_good_pose_gives_none(corridor, seed: int) -> None:
    points = corridor.scan(TRUTH, np.random.default_rng(seed))
    assert search(corridor).find(TRUTH, STEP, points) is None


def test_backward_step_is_searched_ahead(corridor) -> None:
    points = corridor.scan(TRUTH, np.random.default_rng(1))
    counted = TRUTH.compose(Pose(-0.4, 0.0, 0.0))
    assert search(corridor).find(counted, STEP, points) is None
    slipped = search(corridor).find(counted, Pose(-1.4, 0.0, 0.0), points)
    assert slipped is not None
    assert slipped.refined.pose.x == pytest.approx(TRUTH.x, abs=0.06)


def test_too_short_step_gives_none(corridor) -> None:
    points = corridor.scan(TRUTH, np.random.default_rng(1))
    counted = TRUTH.compose(Pose(0.4, 0.0, 0.0))
    assert search(corridor).find(counted, Pose(0.19, 0.0, 0.0), points) is None
    assert search(corridor).find(counted, Pose(1.4, 0.0, 0.0), points) is not None


def test_bare_walls_give_none(corridor) -> None:
    """Only beams to the sides, which fit equally all along the corridor."""
    points = corridor.scan(TRUTH, np.random.default_rng(1))
    sides = points[np.abs(points[:, 0]) < 3.0]
    counted = TRUTH.compose(Pose(0.4, 0.0, 0.0))
    assert search(corridor).find(counted, STEP, sides) is None


def test_higher_min_gain_rejects_the_pose(corridor) -> None:
    points = corridor.scan(TRUTH, np.random.default_rng(1))
    counted = TRUTH.compose(Pose(0.4, 0.0, 0.0))
    assert search(corridor, min_gain=1e3).find(counted, STEP, points) is None
    assert search(corridor).find(counted, STEP, points[:3]) is None

"""Trials of the localizer: construction from a log, and evaluation."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from localization.settings import LocalizationSettings
from maps.pose import Pose
from tools.localize.localize_study import StudyLog, read_study_log, spread, travel_along
from tools.localize.localize_trials import (
    KIDNAP_DISTANCE,
    Outcome,
    frozen_turns,
    global_starts,
    kidnapped_steps,
    kidnaps,
    slips,
    with_distorted_odometry,
)
from tools.logs.carmen import LogError
from tools.logs.log_step import LogStep

POINTS = np.empty((0, 2))


def straight(count: int, step: float = 1.0) -> list[LogStep]:
    """Return scans along the x axis; the odometry is exact in a frame of its own."""
    start = Pose(5.0, -3.0, 1.0)
    along = [Pose(step * number, 0.0, 0.0) for number in range(count)]
    return [
        LogStep(2.0 * number, start.compose(pose), POINTS, pose)
        for number, pose in enumerate(along)
    ]


def increments(steps: list[LogStep]) -> list[Pose]:
    return [a.odometry.between(b.odometry) for a, b in itertools.pairwise(steps)]


@pytest.fixture(scope="module")
def seattle(data_folder: Path) -> StudyLog:
    return read_study_log(data_folder / "logs" / "seattle-corrected.log.gz", 27)


def test_kidnap_leaves_odometry_and_time_stamps_continuous() -> None:
    steps = straight(60)
    carried = kidnapped_steps(steps[:10], steps, np.random.default_rng(1))
    target = carried[10].reference
    assert target is not None
    assert abs(target.x - 9.0) >= KIDNAP_DISTANCE
    assert increments(carried)[9] == pytest.approx((0, 0, 0), abs=1e-9)
    assert np.diff([step.t for step in carried]) == pytest.approx(2.0)
    assert increments(carried)[10] == pytest.approx((1.0, 0, 0))


def test_kidnap_without_another_place_is_an_error() -> None:
    steps = straight(15)
    with pytest.raises(LogError, match="longer log"):
        kidnapped_steps(steps[:5], steps, np.random.default_rng(1))


@pytest.mark.parametrize("distort", [lambda _: Pose(0, 0, 0), lambda step: Pose(2 * step.x, 0, 0)])
def test_only_increments_of_the_stretch_are_distorted(distort: Callable[[Pose], Pose]) -> None:
    steps = straight(10)
    before, after = increments(steps), increments(with_distorted_odometry(steps, 3, 6, distort))
    assert after[:3] == [pytest.approx(each) for each in before[:3]]
    assert after[3:6] == [pytest.approx(distort(each), abs=1e-9) for each in before[3:6]]
    assert after[6:] == [pytest.approx(each) for each in before[6:]]


def test_outcome_counts_from_the_event_on() -> None:
    trial = Outcome(
        travel=np.array([-1.0, 0.0, 1.5, 3.0, 4.0]),
        error=np.array([0.0, 9.0, 9.0, 0.1, 0.1]),
        right=np.array([True, False, False, True, True]),
        localized=np.array([True, True, False, False, True]),
    )
    assert trial.doubted_after == 1.5
    assert trial.found_after == 4.0
    assert trial.wrong_and_localized
    assert trial.summary == {
        "doubted_after_m": 1.5,
        "right_and_localized_after_m": 4.0,
        "wrong_and_localized_scans": 1,
    }


def test_never_is_null_in_json() -> None:
    never = np.zeros(2, dtype=np.bool_)
    trial = Outcome(np.array([0.0, 1.0]), np.full(2, 9.0), never, never)
    assert math.isinf(trial.found_after)
    assert trial.summary["right_and_localized_after_m"] is None


def test_trials_are_spread_evenly() -> None:
    places = list(spread(10, [30, 70]))
    assert [which for which, _ in places].count(0) == 3
    assert places[0] == (0, 5)
    assert places[3] == (1, 5)
    assert all(0 <= index < (30, 70)[which] for which, index in places)


def test_travel_is_along_the_references() -> None:
    assert travel_along(straight(4, 0.5)) == pytest.approx((0.0, 0.5, 1.0, 1.5))


def test_unknown_starts_are_localized(seattle: StudyLog) -> None:
    table, outcomes = global_starts([seattle], 3, LocalizationSettings())
    assert table[0]["right_within_15_m"] == 3
    assert table[0]["wrong_and_localized"] == 0
    assert len(outcomes) == 3


def test_kidnapped_robot_is_localized_again(seattle: StudyLog) -> None:
    table, _ = kidnaps([seattle], 3, LocalizationSettings())
    assert table[0]["recovered_within_20_m"] == 3
    assert table[0]["noticed_within_2_m"] == 3


def test_bad_odometry_keeps_the_error_small(seattle: StudyLog) -> None:
    for study in (frozen_turns, slips):
        table, _ = study([seattle], 3, LocalizationSettings())
        assert table[0]["under_0.3_m"] == 3

"""The alternative hypothesis: ambiguous places are distinguished by the scans on the way there."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from localization.alternative_hypothesis import (
    STOP_XY,
    STOPS_AT_ONCE,
    AlternativeHypothesis,
    AlternativeSearch,
)
from localization.global_search import GlobalSearch
from localization.health import Health
from localization.kld import SampleLimits
from localization.localizer import Localizer
from localization.matching import Matching
from localization.settings import LocalizationSettings, MotionNoise
from maps.pose import Pose

APART = 9.0  # m between the two rooms


def alternative_search(room, seed: int = 3) -> AlternativeSearch:
    settings, rng = LocalizationSettings(), np.random.default_rng(seed)
    return AlternativeSearch(
        settings.motion.over(MotionNoise()),
        SampleLimits(settings.min_particles, settings.max_particles),
        Matching(room.map, settings.beams),
        GlobalSearch(room.map),
        rng,
    )


def walked(alternatives: AlternativeSearch, room, poses: list[Pose]) -> AlternativeSearch:
    """Return the search after scans from each of these poses."""
    rng = np.random.default_rng(7)
    alternatives.remember(None, room.scan(poses[0], rng))
    for before, now in itertools.pairwise(poses):
        alternatives.remember(before.between(now), room.scan(now, rng))
    return alternatives


def found_beside(alternatives: AlternativeSearch, pose: Pose) -> AlternativeHypothesis | None:
    """Return the alternative to a pose, however many calls it takes."""
    found = alternatives.find(pose)
    while alternatives.pending:
        found = alternatives.find(pose)
    return found


def distance(a: Pose, b: Pose) -> float:
    return math.hypot(a.x - b.x, a.y - b.y)


def test_true_pose_is_more_likely_than_an_ambiguous_one(near_twin_rooms, circle) -> None:
    way = circle[:60]
    alternatives = walked(alternative_search(near_twin_rooms), near_twin_rooms, way)
    truth = way[-1]
    look_alike = truth._replace(x=truth.x + APART)

    right, wrong = (found_beside(alternatives, pose) for pose in (truth, look_alike))

    assert right is not None
    assert right.odds > 2.0
    assert right.share > 0.85
    assert wrong is not None
    assert wrong.odds < -2.0
    assert wrong.share < 0.15
    found = wrong.belief.particles[wrong.belief.weights.argmax()]
    assert distance(Pose(*found), truth) < 0.3


def test_identical_rooms_share_the_belief(twin_rooms, circle) -> None:
    alternatives = walked(alternative_search(twin_rooms), twin_rooms, circle[:60])
    alternative = found_beside(alternatives, circle[59])
    assert alternative is not None
    assert alternative.share == pytest.approx(0.5, abs=0.3)


def test_scans_are_kept_by_distance_and_dropped_by_forget(room) -> None:
    alternatives = alternative_search(room)
    step = Pose(STOP_XY / 4.1, 0.0, 0.0)
    start = Pose(3.0, 2.0, 0.0)
    walked(alternatives, room, [start.compose(Pose(i * step.x, 0.0, 0.0)) for i in range(11)])
    assert alternatives.stops == 3
    alternatives.forget()
    assert alternatives.stops == 0


def test_many_scans_are_compared_over_several_calls(near_twin_rooms, circle) -> None:
    way = circle[:60]
    alternatives = walked(alternative_search(near_twin_rooms), near_twin_rooms, way)
    calls = 1
    while alternatives.find(way[-1]) is None:
        assert alternatives.pending
        calls += 1
    assert calls == math.ceil(alternatives.stops / STOPS_AT_ONCE)
    assert not alternatives.pending


def test_another_pose_is_compared_from_the_start(near_twin_rooms, circle) -> None:
    way = circle[:60]
    alternatives = walked(alternative_search(near_twin_rooms), near_twin_rooms, way)
    alternatives.prepare(way[-1])
    look_alike = way[-1]._replace(x=way[-1].x + APART)
    wrong = found_beside(alternatives, look_alike)
    assert wrong is not None
    assert wrong.odds < -2.0


def test_in_one_of_two_identical_rooms_it_is_never_localized(twin_rooms, circle) -> None:
    localizer = Localizer(LocalizationSettings(), twin_rooms.map, np.random.default_rng(2))
    localizer.start_anywhere()
    rng = np.random.default_rng(4)
    healths = [
        localizer.update(0.1 * i, pose, twin_rooms.scan(pose, rng)).health
        for i, pose in enumerate(circle[:200:4])
    ]
    assert Health.LOCALIZED not in healths
    assert healths[-1] is Health.UNSURE


def test_in_one_of_two_similar_rooms_it_localizes_in_the_right_one(near_twin_rooms, circle) -> None:
    for seed in range(2):
        localizer = Localizer(
            LocalizationSettings(), near_twin_rooms.map, np.random.default_rng(seed)
        )
        localizer.start_anywhere()
        rng = np.random.default_rng(4)
        for i, pose in enumerate(circle[:200:4]):
            estimate = localizer.update(0.1 * i, pose, near_twin_rooms.scan(pose, rng))
            if estimate.health is Health.LOCALIZED:
                assert distance(estimate.pose, pose) < 0.3
        assert estimate.health is Health.LOCALIZED

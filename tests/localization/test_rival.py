"""A rival: scans from several places decide between it and the tracked pose, no single one does."""

from __future__ import annotations

import numpy as np
import pytest

from localization.filter import Belief
from localization.matching import Matching
from localization.rival import MIN_SCANS, MIN_TRAVEL, Rival, is_same
from localization.settings import LocalizationSettings, MotionNoise
from maps.pose import Pose

ASIDE = Pose(0.7, 0.3, 0.2)


def rival_at(room, pose: Pose) -> Rival:
    rng = np.random.default_rng(2)
    particles = np.array(pose) + rng.standard_normal((400, 3)) * (0.05, 0.05, 0.02)
    matching = Matching(room.map, LocalizationSettings().beams)
    return Rival(Belief.uniform(particles), pose, MotionNoise(), matching, rng)


def drive(rival: Rival, room, truth: list[Pose], tracked: list[Pose], share: float = 1.0) -> int:
    """Follow a way until one is beaten; return the number of scans. share: of the beams kept."""
    rng = np.random.default_rng(5)
    for number, (pose, other) in enumerate(zip(truth, tracked, strict=True)):
        if number:
            rival.follow(truth[number - 1].between(pose))
        points = room.scan(pose, rng)
        short = rng.random(len(points)) >= share
        points[short] *= 0.4
        rival.weigh(points, 1.0)
        rival.compare(other, points, 1.0)
        if rival.wins or rival.loses:
            return number + 1
    return len(truth)


@pytest.mark.parametrize("share", [1.0, 0.5])
def test_true_rival_wins_after_several_scans_and_some_travel(room, circle, share: float) -> None:
    truth = circle[:100:5]
    rival = rival_at(room, truth[0])
    scans = drive(rival, room, truth, [pose.compose(ASIDE) for pose in truth], share)
    assert rival.wins
    assert is_same(rival.pose, truth[scans - 1])
    assert scans >= MIN_SCANS
    assert scans * 0.175 >= MIN_TRAVEL
    assert rival.share < 0.05


@pytest.mark.parametrize("share", [1.0, 0.5])
def test_wrong_rival_is_beaten_by_a_good_pose(room, circle, share: float) -> None:
    truth = circle[:100:5]
    rival = rival_at(room, truth[0].compose(ASIDE))
    drive(rival, room, truth, truth, share)
    assert rival.loses
    assert rival.share > 0.95


def test_one_scan_alone_never_lets_a_rival_win(room, circle) -> None:
    rival = rival_at(room, circle[0])
    points = room.scan(circle[0])
    for _ in range(10):
        rival.follow(Pose(0.0, 0.0, 0.0))
        rival.compare(circle[0].compose(ASIDE), points, 1.0)
    assert not rival.wins


def test_poses_near_each_other_are_one_hypothesis() -> None:
    assert is_same(Pose(1.0, 2.0, 3.1), Pose(1.1, 2.1, -3.1))
    assert not is_same(Pose(1.0, 2.0, 0.0), Pose(1.4, 2.0, 0.0))
    assert not is_same(Pose(1.0, 2.0, 0.0), Pose(1.0, 2.0, 0.3))

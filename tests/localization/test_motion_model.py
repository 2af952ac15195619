"""The motion model: its mean is the odometry, its spread grows with the counted step."""

from __future__ import annotations

import math

import numpy as np
import pytest

from localization.motion_model import (
    FLOOR_THETA,
    FLOOR_XY,
    MAX_SLIP,
    SLIP_LASTING,
    decompose,
    move_particles,
)
from localization.settings import MotionNoise
from maps.pose import Pose

COUNT = 20000
HERE = Pose(0, 0, 0)
SETTINGS = MotionNoise()


def moved(increment: Pose, start: Pose = HERE, slip_share: float = 0.0) -> np.ndarray:
    particles = np.tile(np.array(start, dtype=np.float64), (COUNT, 1))
    slips, rng = np.zeros(COUNT, np.float32), np.random.default_rng(1)
    return move_particles(particles, slips, increment, SETTINGS, rng, slip_share=slip_share)[0]


@pytest.mark.parametrize(
    "increment",
    [Pose(1, 0, 0), Pose(0.5, 0.3, 0.9), Pose(-0.4, 0.05, -0.2), Pose(0, 0, 2.5), Pose(0, 0, 0)],
)
def test_decomposition_composes_to_the_step(increment: Pose) -> None:
    first, translation, second = decompose(increment)
    again = Pose(0, 0, first).compose(Pose(translation, 0, 0)).compose(Pose(0, 0, second))
    assert again == pytest.approx(increment, abs=1e-12)


def test_a_step_backwards_does_not_turn_round() -> None:
    first, translation, second = decompose(Pose(-0.5, 0.02, 0.1))
    assert abs(first) < 0.1
    assert translation < 0
    assert abs(second) < 0.2


def test_mean_follows_the_odometry_from_the_particles_own_heading() -> None:
    start, step = Pose(3.0, -2.0, 2.0), Pose(0.8, 0.1, 0.3)
    particles = moved(step, start)
    expected = start.compose(step)
    assert particles.mean(axis=0) == pytest.approx(tuple(expected), abs=0.01)


def beyond_the_floor(particles: np.ndarray) -> np.ndarray:
    """Return (3,) the standard deviations without the noise added at every step."""
    floor = np.array((FLOOR_XY, FLOOR_XY, FLOOR_THETA))
    return np.sqrt(np.maximum(particles.var(axis=0) - floor**2, 0.0))


def test_spread_is_proportional_to_distance_and_angle() -> None:
    one, two = (beyond_the_floor(moved(Pose(d, 0, 0))) for d in (1.0, 2.0))
    assert one[0] == pytest.approx(SETTINGS.translation_per_translation, rel=0.05)
    assert one[1] == pytest.approx(SETTINGS.rotation_per_translation, rel=0.05)
    assert one[2] == pytest.approx(SETTINGS.rotation_per_translation * math.sqrt(2), rel=0.05)
    assert two[0] == pytest.approx(2 * one[0], rel=0.05)
    assert two[2] == pytest.approx(2 * one[2], rel=0.05)
    turned = beyond_the_floor(moved(Pose(0, 0, 1.5)))
    assert turned[2] == pytest.approx(SETTINGS.rotation_per_rotation * 1.5, rel=0.05)
    assert turned[0] == pytest.approx(SETTINGS.translation_per_rotation * 1.5, rel=0.1)


def test_zero_step_spreads_by_the_minimum_noise() -> None:
    spread = moved(Pose(0, 0, 0)).std(axis=0)
    assert spread == pytest.approx((FLOOR_XY, FLOOR_XY, FLOOR_THETA), rel=0.05)


def test_some_particles_are_moved_as_if_the_wheels_slipped() -> None:
    particles = moved(Pose(0, 0, 0), slip_share=0.05)
    far = np.hypot(particles[:, 0], particles[:, 1]) > 6.0 * FLOOR_XY
    assert 0.04 < far.mean() < 0.05
    assert np.all(np.flatnonzero(far) % 20 == 0)


def test_a_particle_that_slipped_is_likely_to_slip_again_by_as_much() -> None:
    settings = MotionNoise(translation_per_translation=0.0)
    slips, rng = np.full(COUNT, 0.3, np.float32), np.random.default_rng(1)
    particles, after = move_particles(
        np.zeros((COUNT, 3)), slips, Pose(1.0, 0, 0), settings, rng, slip_share=0.0
    )
    again = after == np.float32(0.3)
    assert again.mean() == pytest.approx(SLIP_LASTING, abs=0.02)
    assert np.all(after[~again] == 0.0)
    assert particles[again, 0].mean() == pytest.approx(0.7, abs=0.01)
    assert particles[~again, 0].mean() == pytest.approx(1.0, abs=0.01)


def test_slipping_particles_lose_at_most_max_slip() -> None:
    _, slips = move_particles(
        np.zeros((COUNT, 3)),
        np.zeros(COUNT, np.float32),
        Pose(1, 0, 0),
        SETTINGS,
        np.random.default_rng(1),
        slip_share=0.1,
    )
    assert np.count_nonzero(slips) == pytest.approx(0.1 * COUNT, rel=0.01)
    assert 0.95 * MAX_SLIP < slips.max() <= MAX_SLIP


def test_headings_stay_wrapped() -> None:
    particles = moved(Pose(0, 0, 3.0), Pose(0, 0, 3.0))
    assert np.abs(particles[:, 2]).max() <= math.pi

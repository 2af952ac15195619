"""The motion model: its mean is the odometry, its spread grows with what was counted."""

from __future__ import annotations

import math

import msgspec
import numpy as np
import pytest

from localization.motion_model import decompose, move_particles
from localization.settings import MotionSettings
from maps.pose import Pose

COUNT = 20000
HERE = Pose(0, 0, 0)
NO_SLIP = MotionSettings(slip_share=0.0)


def moved(increment: Pose, settings: MotionSettings, start: Pose = HERE) -> np.ndarray:
    particles = np.tile(np.array(start, dtype=np.float64), (COUNT, 1))
    return move_particles(
        particles, np.zeros(COUNT, np.float32), increment, settings, np.random.default_rng(1)
    )[0]


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
    particles = moved(step, NO_SLIP, start)
    expected = start.compose(step)
    assert particles.mean(axis=0) == pytest.approx(tuple(expected), abs=0.01)


def test_spread_is_proportional_to_distance_and_angle() -> None:
    settings = MotionSettings(slip_share=0.0, floor_xy=1e-6, floor_theta=1e-6)
    one, two = (moved(Pose(d, 0, 0), settings).std(axis=0) for d in (1.0, 2.0))
    assert one[0] == pytest.approx(settings.translation_per_translation, rel=0.05)
    assert one[1] == pytest.approx(settings.rotation_per_translation, rel=0.05)
    assert one[2] == pytest.approx(settings.rotation_per_translation * math.sqrt(2), rel=0.05)
    assert two[0] == pytest.approx(2 * one[0], rel=0.05)
    assert two[2] == pytest.approx(2 * one[2], rel=0.05)
    turned = moved(Pose(0, 0, 1.5), settings).std(axis=0)
    assert turned[2] == pytest.approx(settings.rotation_per_rotation * 1.5, rel=0.05)
    assert turned[0] == pytest.approx(settings.translation_per_rotation * 1.5, rel=0.1)


def test_a_still_odometer_still_spreads_by_the_floor() -> None:
    spread = moved(Pose(0, 0, 0), NO_SLIP).std(axis=0)
    floors = (NO_SLIP.floor_xy, NO_SLIP.floor_xy, NO_SLIP.floor_theta)
    assert spread == pytest.approx(floors, rel=0.05)


def test_some_particles_are_moved_as_if_the_wheels_slipped() -> None:
    settings = MotionSettings(slip_share=0.05, slip_xy=0.5, slip_theta=0.5)
    particles = moved(Pose(0, 0, 0), settings)
    far = np.hypot(particles[:, 0], particles[:, 1]) > 0.1
    assert 0.03 < far.mean() < 0.05
    assert np.all(np.flatnonzero(far) % 20 == 0)


def test_a_particle_that_slipped_is_likely_to_slip_again_by_as_much() -> None:
    settings = MotionSettings(slip_share=0.0, slip_lasting=0.7, translation_per_translation=0.0)
    slips = np.full(COUNT, 0.3, np.float32)
    particles, after = move_particles(
        np.zeros((COUNT, 3)), slips, Pose(1.0, 0, 0), settings, np.random.default_rng(1)
    )
    again = after == np.float32(0.3)
    assert again.mean() == pytest.approx(0.7, abs=0.02)
    assert np.all(after[~again] == 0.0)
    assert particles[again, 0].mean() == pytest.approx(0.7, abs=0.01)
    assert particles[~again, 0].mean() == pytest.approx(1.0, abs=0.01)


def test_slipping_particles_lose_no_more_than_the_most() -> None:
    settings = MotionSettings(slip_share=0.1, max_slip=0.4, slip_xy=0.0, slip_theta=0.0)
    _, slips = move_particles(
        np.zeros((COUNT, 3)),
        np.zeros(COUNT, np.float32),
        Pose(1, 0, 0),
        settings,
        np.random.default_rng(1),
    )
    assert np.count_nonzero(slips) == pytest.approx(0.1 * COUNT, rel=0.01)
    assert 0.38 < slips.max() <= 0.4


def test_headings_stay_wrapped() -> None:
    particles = moved(Pose(0, 0, 3.0), NO_SLIP, Pose(0, 0, 3.0))
    assert np.abs(particles[:, 2]).max() <= math.pi


def test_noise_floor_of_zero_is_refused() -> None:
    with pytest.raises(msgspec.ValidationError, match="floor_xy"):
        msgspec.convert({"floor_xy": 0.0}, MotionSettings)

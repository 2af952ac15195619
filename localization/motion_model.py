"""Odometry motion model: particles moved by odometry and scattered by its errors.

Thrun, Burgard, Fox, "Probabilistic Robotics", table 5.6 (sample_motion_model_odometry): a step is
a rotation, a translation and a rotation. Two additions against wheel slip: a minimum noise at every
step, and a share of particles that slip. A particle that slipped is likely to slip again by as
much, so that a lasting slip is detected soon.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from localization.settings import MotionNoise
from maps.pose import Pose, wrap_angle

# Standard deviations added at every update: without them the particles would not move while the
# odometry stands still and the robot slips or is turned by hand.
FLOOR_XY = 0.01  # m
FLOOR_THETA = 0.01  # rad
SLIP_SHARE = 0.1  # of the particles, moved as if the wheels had slipped
MAX_SLIP = 0.5  # maximum share of the counted translation that those lose
SLIP_LASTING = 0.7  # share of the particles that slipped which slip again at the next step
SLIP_XY = 0.1  # m; more standard deviation of the particles that slip
SLIP_THETA = 0.1  # rad; likewise
_MIN_TRANSLATION = 0.01  # m; below it the direction of travel is undefined


def decompose(increment: Pose) -> tuple[float, float, float]:
    """Split a step (base_then_from_base_now) into first rotation, translation, second rotation.

    rad, m, rad. A step backwards keeps its small rotations and gets a negative translation.
    """
    translation = math.hypot(increment.x, increment.y)
    if translation < _MIN_TRANSLATION:
        return 0.0, increment.x, increment.theta
    first = math.atan2(increment.y, increment.x)
    if abs(first) > math.pi / 2:
        first, translation = wrap_angle(first + math.pi), -translation
    return first, translation, wrap_angle(increment.theta - first)


def move_particles(
    particles: NDArray[np.float64],
    slips: NDArray[np.float32],
    increment: Pose,
    settings: MotionNoise,
    rng: np.random.Generator,
    *,
    slip_share: float = SLIP_SHARE,
) -> tuple[NDArray[np.float64], NDArray[np.float32]]:
    """Return particles (n, 3) moved by a sample each of the odometry's step, and their slips.

    particles: map_from_base. slips (n,): the share of a counted translation that each particle
    lost at its last step. increment: base_then_from_base_now by raw odometry since the last
    update. slip_share: share of the particles moved as if the wheels had slipped.
    """
    count = len(particles)
    first, translation, second = decompose(increment)
    noise = rng.standard_normal((4, count), dtype=np.float32)
    travel = _translation_sigma(first, translation, second, settings)
    turn = _rotation_sigma(second, translation, settings)
    aside_sigma = np.full(count, FLOOR_XY, dtype=np.float32)
    travel_sigma = np.full(count, math.hypot(FLOOR_XY, travel), dtype=np.float32)
    turn_sigma = np.full(count, math.hypot(FLOOR_THETA, turn), dtype=np.float32)
    slips = slips * (rng.random(count, dtype=np.float32) < SLIP_LASTING)
    if slip_share > 0.0:
        scouts = slice(None, None, max(1, round(1.0 / slip_share)))
        slip_xy = FLOOR_XY + SLIP_XY
        slip_theta = FLOOR_THETA + SLIP_THETA
        aside_sigma[scouts] = slip_xy
        travel_sigma[scouts] = math.hypot(slip_xy, travel)
        turn_sigma[scouts] = math.hypot(slip_theta, turn)
        slips[scouts] = MAX_SLIP * rng.random(len(slips[scouts]), dtype=np.float32)
    # Single precision is sufficient for a step of about a metre.
    heading = particles[:, 2].astype(np.float32)
    heading += first + _rotation_sigma(first, translation, settings) * noise[0]
    ahead = np.float32(translation) * (np.float32(1.0) - slips) + travel_sigma * noise[1]
    aside = aside_sigma * noise[2]
    cosine, sine = np.cos(heading), np.sin(heading)
    theta = heading + second + turn_sigma * noise[3]
    moved = np.empty_like(particles, order="F")
    moved[:, 0] = particles[:, 0] + (ahead * cosine - aside * sine)
    moved[:, 1] = particles[:, 1] + (ahead * sine + aside * cosine)
    moved[:, 2] = theta - math.tau * np.rint(theta / math.tau)
    return moved, slips


def step_covariance(increment: Pose, settings: MotionNoise) -> NDArray[np.float64]:
    """Return the covariance (3, 3) of a step of the odometry without slip; x, y, theta, m and rad.

    It is the same along and across, as half of it comes from the heading at the step's start.
    """
    first, translation, second = decompose(increment)
    travel = _translation_sigma(first, translation, second, settings)
    heading = math.hypot(
        _rotation_sigma(first, translation, settings),
        _rotation_sigma(second, translation, settings),
    )
    xy = math.hypot(FLOOR_XY, travel, translation * heading)
    theta = math.hypot(FLOOR_THETA, heading)
    return np.diag(np.square((xy, xy, theta)))


def _rotation_sigma(rotation: float, translation: float, settings: MotionNoise) -> float:
    return math.hypot(
        settings.rotation_per_rotation * rotation, settings.rotation_per_translation * translation
    )


def _translation_sigma(
    first: float, translation: float, second: float, settings: MotionNoise
) -> float:
    return math.hypot(
        settings.translation_per_translation * translation,
        settings.translation_per_rotation * math.hypot(first, second),
    )

"""Alignment of two scans without a map."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from localization.scan_motion import Surfaces, motion_between, share_on_surfaces, surfaces_of
from maps.pose import Pose

HALF_ROOM = (2.0, 1.5)  # m
STILL = Pose(0.0, 0.0, 0.0)


def seen_from(pose: Pose, half: tuple[float, float] = HALF_ROOM) -> NDArray[np.float64]:
    """Return (n, 2) points of a room round the origin, in the frame of a pose, with noise."""
    angles = np.radians(np.arange(-90.0, 91.0))
    directions = np.exp(1j * (angles + pose.theta))
    with np.errstate(divide="ignore"):
        x = (np.copysign(half[0], directions.real) - pose.x) / directions.real
        y = (np.copysign(half[1], directions.imag) - pose.y) / directions.imag
    ranges = np.minimum(x, y) + np.random.default_rng(3).normal(0.0, 0.01, len(angles))
    ends = ranges * np.exp(1j * angles)
    return np.column_stack((ends.real, ends.imag))


def surfaces(pose: Pose, half: tuple[float, float] = HALF_ROOM) -> Surfaces:
    found = surfaces_of(seen_from(pose, half))
    assert found is not None
    return found


def test_motion_is_found_from_a_guess_without_any() -> None:
    motion = Pose(0.2, 0.05, 0.15)
    found = motion_between(surfaces(STILL), seen_from(motion), STILL)
    assert found is not None
    assert found.pose[:2] == pytest.approx(motion[:2], abs=0.01)
    assert found.pose.theta == pytest.approx(motion.theta, abs=math.radians(0.4))
    assert np.linalg.matrix_rank(found.information) == 3


def test_along_a_corridor_there_is_no_information() -> None:
    corridor = (100.0, 1.0)
    found = motion_between(
        surfaces(STILL, corridor), seen_from(Pose(0.2, 0.1, 0.0), corridor), STILL
    )
    assert found is not None
    along, across, _ = np.diag(found.information)
    assert along < 0.02 * across
    assert found.pose.y == pytest.approx(0.1, abs=0.01)


def test_fewer_points_lie_on_the_surfaces_at_a_wrong_pose() -> None:
    motion = Pose(0.3, 0.1, 0.0)
    first, points = surfaces(STILL), seen_from(motion)
    right = share_on_surfaces(first, points, motion)
    assert right > 0.8
    assert share_on_surfaces(first, points, Pose(-0.3, -0.1, 0.0)) < right


def test_too_few_points_give_no_surfaces_and_no_motion() -> None:
    points = seen_from(STILL)
    assert surfaces_of(points[:12]) is None
    assert surfaces_of(points * 100.0) is None, "too far away"
    assert motion_between(surfaces(STILL), points[:5], STILL) is None

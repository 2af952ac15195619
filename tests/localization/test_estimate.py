"""Carrying a pose forward by odometry."""

from __future__ import annotations

import numpy as np
import pytest

from localization.estimate import Estimate
from localization.health import Health
from maps.pose import Pose


@pytest.fixture
def estimate() -> Estimate:
    return Estimate(
        t=1.0,
        pose=Pose(2.0, 1.0, np.pi / 2),
        odometry=Pose(-5.0, 0.0, 0.0),
        covariance=np.eye(3),
        health=Health.LOCALIZED,
        particle_count=1,
        effective_sample_size=1.0,
        likelihood=1.0,
        refined=True,
    )


def test_pose_at_the_scans_odometry_is_the_estimate(estimate: Estimate) -> None:
    assert estimate.pose_at(estimate.odometry) == pytest.approx(estimate.pose)


def test_step_in_odometry_is_the_same_step_in_the_map(estimate: Estimate) -> None:
    assert estimate.pose_at(Pose(-4.0, 0.5, 0.1)) == pytest.approx((1.5, 2.0, np.pi / 2 + 0.1))

"""Rows and summary of a run: errors, lost scans, share of references inside the ellipses."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from localization.estimate import Estimate
from localization.health import Health
from maps.pose import Pose
from tools.localize.localize_result import LocalizeResult, LocalizeRow

COVARIANCE = np.array(((0.04, 0.012, 0.001), (0.012, 0.01, 0.0005), (0.001, 0.0005, 0.0004)))


def row(pose: Pose, reference: Pose | None, health: Health = Health.LOCALIZED) -> LocalizeRow:
    estimate = Estimate(
        t=1.0,
        pose=pose,
        odometry=Pose(0, 0, 0),
        covariance=COVARIANCE,
        health=health,
        particle_count=500,
        effective_sample_size=250.0,
        likelihood=0.9,
        refined=True,
    )
    return LocalizeRow.of(estimate, reference, 1.5)


def result(*rows: LocalizeRow) -> LocalizeResult:
    return LocalizeResult("log", "map", 0, list(rows))


def test_row_holds_errors_against_the_reference() -> None:
    found = row(Pose(1.0, 2.0, math.pi - 0.1), Pose(1.3, 2.4, -math.pi + 0.1))
    assert found.position_error_m == pytest.approx(0.5)
    assert found.heading_error_deg == pytest.approx(math.degrees(0.2))
    assert found.away == pytest.approx((0.3, 0.4, 0.2))
    assert np.array_equal(found.covariance, COVARIANCE)


def test_row_is_lost_by_health_or_by_error() -> None:
    here, metre = Pose(0, 0, 0), Pose(1.01, 0, 0)
    assert not row(here, here).is_lost
    assert row(here, here, Health.LOST).is_lost
    assert row(here, metre).is_lost
    assert not row(here, None).is_lost
    assert result(row(here, here), row(here, metre)).lost_share == 0.5


def test_coverage_is_95_percent_for_errors_of_the_covariance() -> None:
    rng = np.random.default_rng(1)
    away = rng.multivariate_normal(np.zeros(3), COVARIANCE, 4000)
    rows = [row(Pose(*each), Pose(0, 0, 0)) for each in away.tolist()]
    coverage = result(*rows).coverage()
    assert coverage is not None
    assert coverage.xy == pytest.approx(0.95, abs=0.01)
    assert coverage.pose == pytest.approx(0.95, abs=0.01)
    doubled = [replace(each, x=2 * each.x, y=2 * each.y, theta=2 * each.theta) for each in rows]
    worse = result(*doubled).coverage()
    assert worse is not None
    assert worse.xy < 0.8


def test_without_references_coverage_is_none() -> None:
    alone = result(row(Pose(0, 0, 0), None))
    assert alone.coverage() is None
    assert alone.summary["inside_95"] is None
    assert alone.summary["lost_share"] is None

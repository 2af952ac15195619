"""Transitions between localized, unsure and lost, and their hysteresis."""

from __future__ import annotations

from dataclasses import replace

import pytest

from localization.health import (
    FOUND_ABOVE,
    LOCALIZED_ABOVE,
    LOCALIZED_SHARE,
    LOCALIZED_SPREAD,
    LOCALIZED_WALL_CROSSING,
    LOST_BELOW,
    UNSURE_BELOW,
    UNSURE_SHARE,
    UNSURE_SPREAD,
    UNSURE_WALL_CROSSING,
    Evidence,
    Health,
    HealthMonitor,
)
from localization.scan_check import Fit

GOOD = Evidence(fit=Fit(0.95, 0.95, 1.0, 0.0), spread=0.05, share=1.0)
CLOUDY = replace(GOOD, fit=Fit(0.55, 0.55, 1.0, 0.0))
NOTHING_FITS = replace(GOOD, fit=Fit(0.1, 0.1, 1.0, 0.0))
BLIND = replace(GOOD, fit=None)


def monitor_at(health: Health) -> HealthMonitor:
    return HealthMonitor(health, worsen_after=3, improve_after=5)


def after(health: Health, count: int, evidence: Evidence) -> Health:
    monitor = monitor_at(health)
    for _ in range(count):
        monitor.update(evidence)
    return monitor.health


@pytest.mark.parametrize(
    ("before", "evidence", "needed", "then"),
    [
        (Health.UNSURE, GOOD, 5, Health.LOCALIZED),
        (Health.LOST, GOOD, 5, Health.LOCALIZED),
        (Health.LOST, CLOUDY, 5, Health.UNSURE),
        (Health.LOCALIZED, CLOUDY, 3, Health.UNSURE),
        (Health.LOCALIZED, replace(GOOD, spread=0.6), 3, Health.UNSURE),
        (Health.LOCALIZED, replace(GOOD, share=0.5), 3, Health.UNSURE),
        (Health.LOCALIZED, replace(GOOD, wall_crossing=0.5), 3, Health.UNSURE),
        (Health.LOCALIZED, replace(GOOD, jump_xy=0.6), 3, Health.UNSURE),
        (Health.LOCALIZED, replace(GOOD, jump_theta=0.6), 3, Health.UNSURE),
        (Health.LOCALIZED, replace(GOOD, relocated=True), 3, Health.UNSURE),
        (Health.LOCALIZED, BLIND, 3, Health.UNSURE),
        (Health.LOCALIZED, NOTHING_FITS, 3, Health.LOST),
        (Health.UNSURE, NOTHING_FITS, 3, Health.LOST),
    ],
)
def test_transition_after_enough_updates_in_a_row(
    before: Health, evidence: Evidence, needed: int, then: Health
) -> None:
    assert after(before, needed - 1, evidence) is before
    assert after(before, needed, evidence) is then


@pytest.mark.parametrize(
    ("health", "evidence"),
    [
        (
            Health.LOCALIZED,
            Evidence(fit=Fit(0.65, 0.65, 1.0, 0.0), spread=0.35, share=0.75, wall_crossing=0.35),
        ),
        (Health.LOCALIZED, replace(GOOD, jump_xy=0.45, jump_theta=0.45)),
        (Health.UNSURE, replace(GOOD, fit=Fit(0.65, 0.65, 1.0, 0.0))),
        (Health.UNSURE, replace(GOOD, spread=0.35)),
        (Health.UNSURE, replace(GOOD, share=0.75)),
        (Health.UNSURE, replace(GOOD, wall_crossing=0.3)),
        (Health.UNSURE, replace(GOOD, relocated=True)),
        (Health.UNSURE, replace(GOOD, fit=Fit(0.48, 0.48, 1.0, 0.0))),
        (Health.LOST, replace(GOOD, fit=Fit(0.48, 0.48, 1.0, 0.0))),
        (Health.LOST, BLIND),
        # A crowd does not make a known pose lost, and does not make an unknown one localized.
        (Health.LOCALIZED, replace(GOOD, fit=Fit(0.5, 0.8, 1.0, 0.0))),
        (Health.UNSURE, replace(GOOD, fit=Fit(0.5, 0.8, 1.0, 0.0))),
    ],
)
def test_health_is_kept_between_the_thresholds(health: Health, evidence: Evidence) -> None:
    assert after(health, 50, evidence) is health


def test_scans_from_the_same_place_count_in_part() -> None:
    repeated = replace(NOTHING_FITS, information=0.3)
    assert after(Health.LOCALIZED, 9, repeated) is Health.LOCALIZED
    assert after(Health.LOCALIZED, 10, repeated) is Health.LOST
    assert after(Health.LOST, 16, replace(GOOD, information=0.3)) is Health.LOST
    assert after(Health.LOST, 17, replace(GOOD, information=0.3)) is Health.LOCALIZED


def test_an_interrupted_run_of_bad_scans_does_not_count() -> None:
    monitor = monitor_at(Health.LOCALIZED)
    for _ in range(20):
        monitor.update(NOTHING_FITS)
        monitor.update(NOTHING_FITS)
        assert monitor.update(GOOD) is Health.LOCALIZED


def test_mixed_better_verdicts_improve_to_the_lesser() -> None:
    monitor = monitor_at(Health.LOST)
    for evidence in (GOOD, CLOUDY, GOOD, GOOD, CLOUDY):
        assert monitor.health is Health.LOST
        monitor.update(evidence)
    assert monitor.health is Health.UNSURE


def test_the_better_tail_of_a_run_counts_towards_the_next_step() -> None:
    """Five scans lead from lost to unsure; three of them count for localized already."""
    monitor = monitor_at(Health.LOST)
    for evidence in (CLOUDY, CLOUDY, GOOD, GOOD, GOOD):
        monitor.update(evidence)
    assert monitor.health is Health.UNSURE
    assert monitor.update(GOOD) is Health.UNSURE
    assert monitor.update(GOOD) is Health.LOCALIZED


def test_thresholds_to_improve_are_stricter_than_to_stay() -> None:
    assert LOST_BELOW < FOUND_ABOVE <= UNSURE_BELOW < LOCALIZED_ABOVE
    assert LOCALIZED_WALL_CROSSING < UNSURE_WALL_CROSSING
    assert LOCALIZED_SPREAD < UNSURE_SPREAD
    assert LOCALIZED_SHARE > UNSURE_SHARE


def test_preview_returns_the_next_health_without_changing_it() -> None:
    monitor = monitor_at(Health.UNSURE)
    for _ in range(4):
        assert monitor.preview(GOOD) is Health.UNSURE
        monitor.update(GOOD)
    assert monitor.preview(GOOD) is Health.LOCALIZED
    assert monitor.preview(CLOUDY) is monitor.health is Health.UNSURE
    assert monitor.update(GOOD) is Health.LOCALIZED

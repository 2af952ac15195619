"""Each transition between localized, unsure and lost, and that none happens without cause."""

from __future__ import annotations

import pytest

from localization.health import Health, HealthMonitor
from localization.settings import HealthSettings

SETTINGS = HealthSettings(updates_to_worsen=3, updates_to_improve=5)
GOOD = (0.95, 0.05, 1.0)
CLOUDY = (0.5, 0.05, 1.0)
NOTHING_FITS = (0.1, 0.05, 1.0)


def after(
    health: Health, count: int, likelihood: float | None, spread: float, share: float
) -> Health:
    monitor = HealthMonitor(SETTINGS, health)
    for _ in range(count):
        monitor.update(likelihood, spread, share)
    return monitor.health


@pytest.mark.parametrize(
    ("before", "measured", "needed", "then"),
    [
        (Health.UNSURE, GOOD, 5, Health.LOCALIZED),
        (Health.LOST, GOOD, 5, Health.LOCALIZED),
        (Health.LOST, CLOUDY, 5, Health.UNSURE),
        (Health.LOCALIZED, CLOUDY, 3, Health.UNSURE),
        (Health.LOCALIZED, (0.95, 0.6, 1.0), 3, Health.UNSURE),
        (Health.LOCALIZED, (0.95, 0.05, 0.5), 3, Health.UNSURE),
        (Health.LOCALIZED, (None, 0.05, 1.0), 3, Health.UNSURE),
        (Health.LOCALIZED, NOTHING_FITS, 3, Health.LOST),
        (Health.UNSURE, NOTHING_FITS, 3, Health.LOST),
    ],
)
def test_transition_after_enough_updates_in_a_row(
    before: Health, measured: tuple[float | None, float, float], needed: int, then: Health
) -> None:
    assert after(before, needed - 1, *measured) is before
    assert after(before, needed, *measured) is then


@pytest.mark.parametrize(
    ("health", "measured"),
    [
        (Health.LOCALIZED, (0.6, 0.35, 0.75)),
        (Health.UNSURE, (0.6, 0.05, 1.0)),
        (Health.UNSURE, (0.95, 0.35, 1.0)),
        (Health.UNSURE, (0.95, 0.05, 0.75)),
        (Health.UNSURE, (0.4, 0.05, 1.0)),
        (Health.LOST, (0.4, 0.05, 1.0)),
        (Health.LOST, (None, 0.05, 1.0)),
    ],
)
def test_between_the_thresholds_nothing_changes(
    health: Health, measured: tuple[float | None, float, float]
) -> None:
    assert after(health, 50, *measured) is health


def test_an_interrupted_run_of_bad_scans_does_not_count() -> None:
    monitor = HealthMonitor(SETTINGS, Health.LOCALIZED)
    for _ in range(20):
        monitor.update(*NOTHING_FITS)
        monitor.update(*NOTHING_FITS)
        assert monitor.update(*GOOD) is Health.LOCALIZED


def test_verdicts_that_waver_between_two_better_ones_count_for_the_lesser() -> None:
    monitor = HealthMonitor(SETTINGS, Health.LOST)
    for measured in (GOOD, CLOUDY, GOOD, GOOD, CLOUDY):
        assert monitor.health is Health.LOST
        monitor.update(*measured)
    assert monitor.health is Health.UNSURE


@pytest.mark.parametrize(
    "wrong",
    [
        {"lost_below": 0.9},
        {"localized_above": 0.4},
        {"localized_spread": 0.9},
        {"unsure_share": 0.9},
    ],
)
def test_unordered_thresholds_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(ValueError, match="must"):
        HealthSettings(**wrong)

"""Freshness limits: one table for gate, alarms and the README of the room."""

from pathlib import Path

from drivers.lms200.settings import LaserSettings
from robot_agent.motion.freshness_limits import (
    BASE,
    CALM_S,
    LASER,
    LIMITS,
    FreshnessWatch,
    markdown,
    scan_age_limit,
)
from robot_agent.motion.gate_limits import GateLimits

README = Path(__file__).parents[3] / "robot_agent" / "motion" / "README.md"


def test_readme_has_the_table_of_limits():
    assert markdown() in README.read_text()


def test_gate_limits_equal_the_table():
    settings = GateLimits()
    assert settings.max_base_age == BASE.max_age
    assert settings.scan_age == LASER.max_age


def test_scan_age_limit_follows_the_scan_period():
    usual = LaserSettings()
    assert abs(scan_age_limit(usual.scan_period) - LASER.max_age) < 0.001
    fast, slow = LaserSettings(baud=500000), LaserSettings(baud=19200)
    assert scan_age_limit(fast.scan_period) == 0.2
    assert scan_age_limit(slow.scan_period) == 0.45


def test_one_scan_may_be_lost_at_the_usual_rate():
    """It is a period old when it comes, two when the next one is due, three when that is lost."""
    slow = LaserSettings(resolution_deg=0.5)
    for settings in (LaserSettings(), LaserSettings(baud=500000), slow):
        period = settings.scan_period
        may_be_lost = settings is not slow
        assert (scan_age_limit(period) > 3.0 * period) == may_be_lost
        assert scan_age_limit(period) > 2.0 * period


def test_every_limit_allows_one_lost_datum():
    for stream in LIMITS:
        assert stream.max_age >= 1.0 / stream.rate


def test_stale_and_fresh_again_are_each_reported_once():
    watch = FreshnessWatch()
    assert watch.changes(0.0) == []
    watch.mark_valid(BASE, 1.0)
    assert watch.changes(0.99 + BASE.max_age) == []
    assert watch.changes(1.01 + BASE.max_age) == [(BASE, False)]
    assert watch.changes(2.0) == []
    for tenth in range(21, 40):
        watch.mark_valid(BASE, 0.1 * tenth)
        assert watch.changes(0.1 * tenth) == []
    watch.mark_valid(BASE, 2.05 + CALM_S)
    assert watch.changes(2.05 + CALM_S) == [(BASE, True)]
    assert watch.changes(2.1 + CALM_S) == []


def test_a_stream_too_slow_for_its_limit_is_told_of_once():
    watch = FreshnessWatch()
    told = []
    for number in range(30):
        t = number * 2.0 * LASER.max_age
        watch.mark_valid(LASER, t)
        told += watch.changes(t) + watch.changes(t + 1.5 * LASER.max_age)
    assert told == [(LASER, False)]

"""Settings of the gate and the limits that result."""

import pytest

from robot_agent.motion.freshness_limits import LASER, scan_age_limit
from robot_agent.motion.gate_limits import GateLimits
from robot_agent.motion.gate_settings import GateSettings, gate_limits


def test_without_settings_the_limits_are_the_defaults():
    assert gate_limits(GateSettings()) == GateLimits()


def test_settings_become_limits():
    limits = gate_limits(GateSettings(front=0.3, max_speed=0.2, battery_cutoff=11.5))
    assert (limits.front, limits.max_speed, limits.battery_cutoff) == (0.3, 0.2, 11.5)


def test_scan_period_sets_the_age_limit_of_scans():
    assert gate_limits(GateSettings(), 0.05).scan_age == scan_age_limit(0.05)
    assert gate_limits(GateSettings()).scan_age == LASER.max_age


def test_battery_resume_below_cutoff_raises():
    with pytest.raises(ValueError, match="battery_resume"):
        GateSettings(battery_cutoff=11.5, battery_resume=11.0)

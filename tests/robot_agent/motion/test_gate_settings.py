"""Settings of the gate and the limits that result."""

import math

import msgspec
import pytest

from drivers.p2os.model import load_model
from robot_agent.motion.freshness_limits import LASER, scan_age_limit
from robot_agent.motion.gate_limits import GateLimits
from robot_agent.motion.gate_settings import GateSettings, gate_limits

MODEL = load_model("p2dx")


def test_without_settings_the_limits_are_the_defaults():
    assert gate_limits(GateSettings(), MODEL) == GateLimits()


def test_settings_become_limits():
    limits = gate_limits(GateSettings(max_speed=0.2, battery_cutoff=11.5), MODEL)
    assert (limits.max_speed, limits.battery_cutoff) == (0.2, 11.5)


def test_body_is_that_of_the_model_and_the_front_margin_lets_its_corners_turn():
    limits = gate_limits(GateSettings(), load_model("p3at"))
    assert (limits.front, limits.rear, limits.half_width) == (0.313, 0.313, 0.2525)
    assert limits.front + limits.front_margin > math.hypot(limits.rear, limits.half_width)


def test_turn_margin_of_a_body_that_reaches_far_is_larger():
    assert gate_limits(GateSettings(), load_model("p2dx")).turn_margin == 0.02
    assert gate_limits(GateSettings(), load_model("powerbot")).turn_margin == pytest.approx(
        math.radians(3.0) * math.hypot(0.542, 0.34)
    )


def test_cut_offs_of_a_24_v_battery_are_doubled():
    limits = gate_limits(GateSettings(), msgspec.structs.replace(MODEL, battery=24))
    assert (limits.battery_cutoff, limits.battery_resume) == (22.0, 24.0)


def test_scan_period_sets_the_age_limit_of_scans():
    assert gate_limits(GateSettings(), MODEL, 0.05).scan_age == scan_age_limit(0.05)
    assert gate_limits(GateSettings(), MODEL).scan_age == LASER.max_age


def test_battery_resume_below_cutoff_raises():
    with pytest.raises(ValueError, match="battery_resume"):
        GateSettings(battery_cutoff=11.5, battery_resume=11.0)

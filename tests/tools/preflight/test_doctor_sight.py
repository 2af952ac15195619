from __future__ import annotations

import math

import msgspec
import pytest

from drivers.lms200.settings import LaserSettings
from drivers.p2os.model import load_model
from robot_agent.motion.gate_limits import GateLimits
from tools.preflight.doctor_sight import examine_sight
from tools.preflight.finding import Verdict

MODEL = load_model("p2dx")
DEAF = msgspec.structs.replace(MODEL, sonar=MODEL.sonar[8:])


@pytest.mark.parametrize(
    ("mount", "fov", "model", "verdict"),
    [
        (None, 180, MODEL, Verdict.OK),
        (None, 100, MODEL, Verdict.OK),
        (None, 180, DEAF, Verdict.OK),
        ((0.0, 0.0, math.pi), 180, MODEL, Verdict.WARNING),
        ((0.0, 0.0, math.pi), 180, DEAF, Verdict.FAILED),
        ((0.0, 0.0, math.pi / 2), 100, DEAF, Verdict.FAILED),
    ],
)
def test_way_ahead_must_be_covered_by_laser_or_front_sonars(mount, fov, model, verdict) -> None:
    settings = LaserSettings(mount=mount, field_of_view_deg=fov)
    finding = examine_sight(settings, model, GateLimits())
    assert finding.verdict is verdict
    assert finding.subject == "sight"
    assert verdict is Verdict.OK or "laser.mount" in finding.remedy


def test_way_in_an_ignored_sector_is_not_covered_by_the_laser() -> None:
    settings = LaserSettings(ignore=((80.0, 100.0),))
    assert examine_sight(settings, MODEL, GateLimits()).verdict is Verdict.WARNING
    assert examine_sight(settings, DEAF, GateLimits()).verdict is Verdict.FAILED


def test_finding_names_the_angle_at_which_the_laser_looks() -> None:
    settings = LaserSettings(mount=(0.0, 0.0, math.pi))
    assert "180 deg" in examine_sight(settings, MODEL, GateLimits()).text


def test_way_outside_the_sector_that_is_sent_is_not_covered_by_the_laser() -> None:
    assert examine_sight(LaserSettings(sector=(30, 150)), MODEL, GateLimits()).verdict is Verdict.OK
    beside = LaserSettings(sector=(0, 80))
    assert examine_sight(beside, MODEL, GateLimits()).verdict is Verdict.WARNING
    over = LaserSettings(sector=(0, 100), upside_down=True)
    assert examine_sight(over, DEAF, GateLimits()).verdict is Verdict.FAILED

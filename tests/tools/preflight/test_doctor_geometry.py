from __future__ import annotations

from drivers.lms200.settings import LaserSettings
from drivers.p2os.settings import BaseSettings
from tools.preflight.doctor_geometry import examine_geometry
from tools.preflight.finding import Verdict


def test_warns_while_neither_mount_nor_wheels_were_calibrated() -> None:
    finding = examine_geometry(BaseSettings(), LaserSettings())
    assert finding.verdict is Verdict.WARNING
    assert "patrol calibrate laser" in finding.remedy


def test_one_of_both_calibrated_is_enough() -> None:
    measured = LaserSettings(mount=(0.02, 0.0, 0.01))
    wheels = BaseSettings(wheel_scale=(1.01, 0.99))
    assert examine_geometry(BaseSettings(), measured).verdict is Verdict.OK
    assert examine_geometry(wheels, LaserSettings()).verdict is Verdict.OK

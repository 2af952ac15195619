from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from drivers.p2os.base_state import BaseState, base_state
from drivers.p2os.model import load_model
from drivers.p2os.odometer import Odometer
from drivers.p2os.sip import decode_sip
from maps.pose import Pose
from robot_agent.motion.freshness_limits import SONAR
from robot_agent.obstacles.sonar_obstacles import SonarObstacles

MODEL = load_model("p2dx")
ORIGIN = Pose(0.0, 0.0, 0.0)
IDLE = bytes.fromhex("32 00 00 00 00 00 00 00 00 00 00 80 00 00 00 00 00 00 00 00 05 00 00 FF 00")


def report(t: float, *readings: tuple[int, float]) -> BaseState:
    sip = decode_sip(IDLE)
    assert sip is not None
    return replace(base_state(t, sip, Odometer(), MODEL), sonar=readings)


def test_only_sonars_beside_and_behind_are_used() -> None:
    sonar = SonarObstacles(MODEL)
    sonar.update(report(1.0, *[(number, 1.0) for number in range(16)]), ORIGIN, MODEL)
    points = sonar.around(1.0, ORIGIN)
    assert len(points) == 10
    assert (points[:, 0] < 0.07).all()
    assert points[0] == pytest.approx((0.069, 1.136))
    assert points[5] == pytest.approx(
        (-0.255 - math.cos(math.radians(10)), -0.027 - math.sin(math.radians(10)))
    )


def test_echoes_stay_in_place_while_the_robot_moves_on() -> None:
    sonar = SonarObstacles(MODEL)
    sonar.update(report(1.0, (0, 1.0)), Pose(2.0, 3.0, math.pi / 2), MODEL)
    points = sonar.around(1.2, Pose(2.0, 3.1, math.pi / 2))
    assert points == pytest.approx(np.array([(-0.031, 1.136)]))


def test_old_echoes_and_silent_transducers_are_left_out() -> None:
    sonar = SonarObstacles(MODEL)
    sonar.update(report(1.0, (0, 1.0), (15, 1.0), (8, MODEL.sonar_far)), ORIGIN, MODEL)
    assert len(sonar.around(1.0 + SONAR.max_age, ORIGIN)) == 2
    sonar.update(report(1.3, (0, MODEL.sonar_far)), ORIGIN, MODEL)
    assert len(sonar.around(1.3, ORIGIN)) == 1
    assert len(sonar.around(1.1 + SONAR.max_age, ORIGIN)) == 0


def test_change_of_model_drops_echoes() -> None:
    sonar = SonarObstacles(MODEL)
    sonar.update(report(1.0, (0, 1.0)), ORIGIN, MODEL)
    other = load_model("p2at")
    sonar.update(report(1.1), ORIGIN, other)
    assert len(sonar.around(1.1, ORIGIN)) == 0
    sonar.update(report(1.2, (0, 1.0)), ORIGIN, other)
    assert sonar.around(1.2, ORIGIN) == pytest.approx(np.array([(0.147, 1.136)]))

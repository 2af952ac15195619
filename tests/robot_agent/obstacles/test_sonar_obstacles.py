from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from maps.pose import Pose
from robot_agent.motion.field_of_view import are_covered
from robot_agent.motion.freshness_limits import SONAR
from robot_agent.obstacles.sonar_obstacles import (
    CONFIRM_WITHIN,
    FRONT_REACH,
    MEMORY,
    SonarObstacles,
)
from tests.robot_agent.obstacles.sonar_report import MODEL, sonar_report

ORIGIN = Pose(0.0, 0.0, 0.0)


def test_one_echo_counts_beside_and_behind_but_not_ahead() -> None:
    sonar = SonarObstacles(MODEL)
    sonar.update(sonar_report(1.0, *[(number, 1.0) for number in range(16)]), ORIGIN, no_scan)
    points = sonar.around(1.0, ORIGIN)
    assert len(points) == 10
    assert (points[:, 0] < 0.07).all()
    assert points[0] == pytest.approx((0.069, 1.136))
    assert points[5] == pytest.approx(
        (-0.255 - math.cos(math.radians(10)), -0.027 - math.sin(math.radians(10)))
    )


AHEAD = 3  # at (0.166, 0.027), heading 10 degrees
NO_SCAN = np.empty((0, 2))


def no_scan() -> NDArray[np.float64]:
    return NO_SCAN


def echo_ahead(distance: float) -> tuple[float, float]:
    """Position of its echo, base_link."""
    angle = math.radians(10.0)
    return 0.166 + distance * math.cos(angle), 0.027 + distance * math.sin(angle)


def heard(*readings: float, seen: NDArray[np.float64] = NO_SCAN) -> NDArray[np.float64]:
    """Points after readings of one front transducer, 0.3 s apart."""
    sonar, t = SonarObstacles(MODEL), 1.0
    for number, reading in enumerate(readings):
        t = 1.0 + 0.3 * number
        sonar.update(sonar_report(t, (AHEAD, reading)), ORIGIN, lambda: seen)
    return sonar.around(t, ORIGIN)


def test_front_echo_counts_when_a_second_one_confirms_it() -> None:
    assert len(heard(0.5)) == 0
    assert heard(0.5, 0.55) == pytest.approx(np.array([echo_ahead(0.55)]))
    assert len(heard(0.5, 0.7)) == 0


def test_transducer_beside_confirms_a_front_echo() -> None:
    sonar = SonarObstacles(MODEL)
    sonar.update(sonar_report(1.0, (4, 0.25)), ORIGIN, no_scan)
    sonar.update(sonar_report(1.1, (AHEAD, 0.25)), ORIGIN, no_scan)
    assert len(sonar.around(1.1, ORIGIN)) == 1


def test_echo_of_long_ago_confirms_nothing() -> None:
    sonar = SonarObstacles(MODEL)
    sonar.update(sonar_report(1.0, (AHEAD, 0.5)), ORIGIN, no_scan)
    sonar.update(sonar_report(1.01 + CONFIRM_WITHIN, (AHEAD, 0.5)), ORIGIN, no_scan)
    assert len(sonar.around(1.01 + CONFIRM_WITHIN, ORIGIN)) == 0


def test_front_echo_of_what_the_laser_sees_is_left_to_the_laser() -> None:
    assert len(heard(0.5, 0.5, seen=np.array([echo_ahead(0.5)]))) == 0
    assert len(heard(0.5, 0.5, seen=np.array([(0.3, 0.05)]))) == 0  # nearer, in its cone


def test_low_box_before_a_wall_counts() -> None:
    wall = np.column_stack((np.full(41, 1.0), np.linspace(-1.0, 1.0, 41)))
    assert len(heard(0.5, 0.5, seen=wall)) == 1


def test_wall_of_a_narrow_corridor_that_the_laser_sees_does_not_stop_the_robot() -> None:
    x = np.linspace(-2.0, 2.0, 161)
    walls = np.concatenate([np.column_stack((x, np.full_like(x, y))) for y in (-0.45, 0.45)])
    sonar = SonarObstacles(MODEL)
    for t in (1.0, 1.3, 1.6):
        # The nearest part of the wall in each cone: at 25, 45 and 65 degrees.
        readings = [(3, 1.0), (2, 0.526), (1, 0.365), (4, 1.0), (5, 0.526), (6, 0.365)]
        sonar.update(sonar_report(t, *readings), ORIGIN, lambda: walls)
    assert len(sonar.around(1.6, ORIGIN)) == 0


def test_frame_of_a_door_that_the_laser_sees_does_not_stop_the_robot() -> None:
    y = np.linspace(0.425, 1.0, 47)
    near = np.concatenate([np.column_stack((np.full_like(y, 0.27), side * y)) for side in (1, -1)])
    x = np.linspace(0.27, 0.42, 13)
    inside = [np.column_stack((x, np.full_like(x, side * 0.425))) for side in (1, -1)]
    frame = np.concatenate((near, *inside))
    sonar = SonarObstacles(MODEL)
    for t in (1.0, 1.3, 1.6):
        # Off the axis by 25 degrees, the transducers at 30 degrees hear the inner side.
        sonar.update(sonar_report(t, (2, 0.42), (5, 0.42)), ORIGIN, lambda: frame)
    assert len(sonar.around(1.6, ORIGIN)) == 0


def test_front_echo_is_kept_until_the_transducer_hears_past_its_place_twice() -> None:
    assert len(heard(0.5, 0.5, 1.2)) == 1, "a slanted face sends one ping elsewhere"
    assert len(heard(0.5, 0.5, 1.2, MODEL.sonar_far)) == 0
    assert len(heard(0.5, 0.5, MODEL.sonar_far, MODEL.sonar_far)) == 0
    sonar = SonarObstacles(MODEL)
    for t in (1.0, 1.3):
        sonar.update(sonar_report(t, (AHEAD, 0.4)), ORIGIN, no_scan)
    turned = Pose(0.0, 0.0, math.radians(90.0))
    sonar.update(sonar_report(1.6, (AHEAD, MODEL.sonar_far)), turned, no_scan)
    place = sonar.around(1.6, turned)
    assert place == pytest.approx(np.array([(echo_ahead(0.4)[1], -echo_ahead(0.4)[0])]))
    assert len(sonar.around(1.3 + MEMORY, ORIGIN)) == 1
    assert len(sonar.around(1.31 + MEMORY, ORIGIN)) == 0


def test_front_echoes_too_far_to_matter_are_left_out() -> None:
    assert len(heard(FRONT_REACH, FRONT_REACH)) == 0


def test_front_sonars_cover_the_way_ahead_while_they_are_fresh() -> None:
    sonar = SonarObstacles(MODEL)
    assert sonar.views(1.0) == ()
    sonar.update(sonar_report(1.0, *[(number, 5.0) for number in range(16)]), ORIGIN, no_scan)
    views = sonar.views(1.0 + SONAR.max_age)
    assert len(views) == 6
    for way in np.linspace(0.0, 0.6, 13):
        for aside in np.linspace(-0.2925, 0.2925, 13):
            assert are_covered([(0.41 + way, aside)], views)
    assert not are_covered([(-0.5, 0.0)], views)
    assert sonar.views(1.01 + SONAR.max_age) == ()


def test_echoes_stay_in_place_while_the_robot_moves_on() -> None:
    sonar = SonarObstacles(MODEL)
    sonar.update(sonar_report(1.0, (0, 1.0)), Pose(2.0, 3.0, math.pi / 2), no_scan)
    points = sonar.around(1.2, Pose(2.0, 3.1, math.pi / 2))
    assert points == pytest.approx(np.array([(-0.031, 1.136)]))


def test_old_echoes_and_silent_transducers_are_left_out() -> None:
    sonar = SonarObstacles(MODEL)
    sonar.update(sonar_report(1.0, (0, 1.0), (15, 1.0), (8, MODEL.sonar_far)), ORIGIN, no_scan)
    assert len(sonar.around(1.0 + SONAR.max_age, ORIGIN)) == 2
    sonar.update(sonar_report(1.3, (0, MODEL.sonar_far)), ORIGIN, no_scan)
    assert len(sonar.around(1.3, ORIGIN)) == 1
    assert len(sonar.around(1.1 + SONAR.max_age, ORIGIN)) == 0

"""Odometry at a time: interpolated, extrapolated, or None."""

import math

import pytest

from drivers.p2os.base_state import BaseState
from robot_agent.pose.odometry_history import CARRIED_S, KEPT_S, OdometryHistory


def state(t: float, x: float, *, theta: float = 0.0, v: float = 0.0, w: float = 0.0) -> BaseState:
    return BaseState(
        t=t,
        x=x,
        y=0.0,
        theta=theta,
        v=v,
        w=w,
        v_left=v,
        v_right=v,
        battery=12.0,
        stall_left=False,
        stall_right=False,
        front_bumpers=0,
        rear_bumpers=0,
        motors_enabled=True,
        sonar_on=True,
        flags=0,
        sonar=(),
    )


def test_pose_is_none_before_the_first_report() -> None:
    history = OdometryHistory()
    assert history.at(1.0) is None
    assert history.latest is None


def test_interpolates_between_reports() -> None:
    history = OdometryHistory()
    history.add(state(1.0, 0.0))
    history.add(state(1.1, 0.1, theta=0.2))
    assert history.at(1.025) == pytest.approx((0.025, 0.0, 0.05))
    assert history.at(1.1) == pytest.approx((0.1, 0.0, 0.2))


def test_theta_is_wrapped_though_reports_are_not() -> None:
    history = OdometryHistory()
    history.add(state(1.0, 0.0, theta=3.0))
    history.add(state(2.0, 0.0, theta=3.4))
    pose = history.at(1.75)
    assert pose is not None
    assert pose.theta == pytest.approx(3.3 - math.tau)


def test_extrapolates_past_the_newest_report() -> None:
    history = OdometryHistory()
    history.add(state(1.0, 0.0, v=0.5, w=0.2))
    pose = history.at(1.1)
    assert pose is not None
    assert pose.x == pytest.approx(0.05 * math.cos(0.01))
    assert pose.y == pytest.approx(0.05 * math.sin(0.01))
    assert pose.theta == pytest.approx(0.02)


def test_pose_is_none_for_times_before_the_history() -> None:
    history = OdometryHistory()
    for step in range(50):
        history.add(state(step * 0.1, step * 0.01))
    assert history.at(4.9 - KEPT_S - 0.2) is None
    assert history.at(4.9 - KEPT_S + 0.2) is not None


def test_reports_out_of_order_are_ignored() -> None:
    history = OdometryHistory()
    history.add(state(1.0, 0.0))
    history.add(state(0.9, 5.0))
    assert history.at(1.0) == pytest.approx((0.0, 0.0, 0.0))


def test_speeds_are_those_of_the_nearest_report() -> None:
    history = OdometryHistory()
    assert history.twist_at(0.0) == (0.0, 0.0)
    history.add(state(1.0, 0.0, v=0.1, w=0.2))
    history.add(state(2.0, 0.0, v=0.3, w=0.4))
    assert history.twist_at(1.4) == (0.1, 0.2)
    assert history.twist_at(1.6) == (0.3, 0.4)
    assert history.twist_at(9.0) == (0.3, 0.4)


def test_pose_is_none_long_after_the_newest_report() -> None:
    history = OdometryHistory()
    history.add(state(1.0, 0.0, v=0.5))
    assert history.at(1.0 + CARRIED_S) is not None
    assert history.at(1.01 + CARRIED_S) is None

"""Odometry corrected by the calibrated wheels."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from drivers.p2os.base_state import BaseState
from drivers.p2os.settings import BaseSettings
from drivers.p2os.wheel_correction import WheelCorrection

TRACK = 0.4  # m, of the model
TURN = 2.0 / TRACK
START = BaseState(
    t=0.0,
    x=0.0,
    y=0.0,
    theta=0.0,
    v=0.0,
    w=0.0,
    v_left=0.0,
    v_right=0.0,
    battery=12.0,
    stall_left=False,
    stall_right=False,
    front_bumpers=0,
    rear_bumpers=0,
    motors_enabled=True,
    sonar_on=False,
    flags=0,
    sonar=(),
)


def driven(settings: BaseSettings, left: float, right: float, steps: int = 200) -> BaseState:
    """Return the corrected report after wheels counted ways left, right, m, in steps."""
    wheels, state = WheelCorrection(settings), START
    corrected = wheels.corrected(state, TURN)
    for step in range(1, steps + 1):
        way, turned = 0.5 * (left + right) / steps, (right - left) / TRACK / steps
        middle = state.theta + 0.5 * turned
        state = replace(
            state,
            t=0.1 * step,
            x=state.x + way * math.cos(middle),
            y=state.y + way * math.sin(middle),
            theta=state.theta + turned,
            v_left=left / steps / 0.1,
            v_right=right / steps / 0.1,
        )
        corrected = wheels.corrected(state, TURN)
    return corrected


def test_without_a_calibration_reports_are_as_counted() -> None:
    assert WheelCorrection(BaseSettings()).corrected(START, TURN) is START


def test_ways_and_speeds_are_scaled() -> None:
    state = driven(BaseSettings(wheel_scale=(1.1, 1.1)), 2.0, 2.0)
    assert (state.x, state.y, state.theta) == pytest.approx((2.2, 0.0, 0.0))
    assert state.v == pytest.approx(2.2 / 20.0)
    assert state.w == pytest.approx(0.0)


def test_backwards_ways_are_scaled_too() -> None:
    assert driven(BaseSettings(wheel_scale=(1.1, 1.1)), -2.0, -2.0).x == pytest.approx(-2.2)


def test_unequal_wheels_bend_a_way_counted_straight() -> None:
    state = driven(BaseSettings(wheel_scale=(1.0, 1.02)), 2.0, 2.0)
    assert state.theta == pytest.approx(0.02 * 2.0 / TRACK)
    radius = 2.02 / state.theta
    assert state.y == pytest.approx(radius * (1.0 - math.cos(state.theta)), rel=1e-3)


def test_a_wider_track_turns_less_than_counted() -> None:
    state = driven(BaseSettings(track=0.44), -0.5, 0.5)
    assert state.theta == pytest.approx(1.0 / 0.44)
    assert state.w == pytest.approx(1.0 / 0.44 / 20.0)
    assert math.hypot(state.x, state.y) == pytest.approx(0.0, abs=1e-9)

from __future__ import annotations

import math

import pytest

from drivers.p2os.command_numbers import CommandNumber
from drivers.p2os.commands import Command
from drivers.p2os.emulator.base import FACTORY_WATCHDOG, STALL_PAUSE, TICKS_PER_METRE, EmulatedBase
from drivers.p2os.emulator.make import PIONEER_2DX

N = CommandNumber


def base(*commands: Command) -> EmulatedBase:
    """Return a base with its motors on after ``commands`` at t = 0."""
    made = EmulatedBase(PIONEER_2DX)
    made.run_to(0.0)
    made.heard_at = 0.0
    made.open_session()
    made.enable_motors(on=True)
    for command in commands:
        assert made.obey_motion(command)
    return made


def test_motors_need_a_session_and_a_released_button() -> None:
    robot = EmulatedBase(PIONEER_2DX)
    robot.enable_motors(on=True)
    assert not robot.motors_enabled
    robot.open_session()
    robot.press_stop_button()
    robot.enable_motors(on=True)
    assert not robot.motors_enabled
    robot.stop_button_pressed = False
    robot.enable_motors(on=True)
    assert robot.motors_enabled
    robot.close_session()
    assert not robot.motors_enabled


def test_without_motors_motion_is_refused_and_setpoints_are_not_kept() -> None:
    robot = base()
    robot.enable_motors(on=False)
    assert not robot.obey_motion(Command(N.VEL, 300))
    robot.enable_motors(on=True)
    robot.run_to(1.0)
    assert robot.velocity == (0.0, 0.0)


def test_stop_button_stops_the_wheels_at_once() -> None:
    robot = base(Command(N.VEL, 300), Command(N.RVEL, 20))
    robot.run_to(1.5)
    assert robot.velocity[0] == pytest.approx(0.3)
    robot.press_stop_button()
    assert robot.velocity == (0.0, 0.0)


def test_watchdog_halts_and_the_next_packet_resumes() -> None:
    robot = base(Command(N.VEL, 300))
    robot.run_to(FACTORY_WATCHDOG - 0.01)
    assert robot.velocity[0] == pytest.approx(0.3)
    robot.run_to(FACTORY_WATCHDOG + 1.5)
    assert robot.watchdog_expired
    assert not robot.motion_permitted
    assert robot.velocity == (0.0, 0.0)
    robot.heard_at = FACTORY_WATCHDOG + 1.5
    robot.run_to(FACTORY_WATCHDOG + 3.0)
    assert robot.velocity[0] == pytest.approx(0.3)


def test_watchdog_has_the_value_of_the_flash() -> None:
    robot = EmulatedBase(PIONEER_2DX, watchdog=1.2)
    robot.run_to(0.0)
    robot.heard_at = 0.0
    robot.run_to(1.19)
    assert not robot.watchdog_expired
    robot.run_to(1.2)
    assert robot.watchdog_expired


def test_motion_follows_the_profile_and_is_fetched_once() -> None:
    robot = base(Command(N.VEL, 300))
    robot.run_to(1.0)
    distance, rotation = robot.pop_motion()
    assert (distance, rotation) == (pytest.approx(0.15, abs=0.002), 0.0)
    assert robot.pop_motion() == (0.0, 0.0)


def test_stall_cuts_power_for_the_stall_pause() -> None:
    robot = base(Command(N.VEL, 300))
    robot.run_to(1.0)
    robot.set_contact(stalled=True, front_bumpers=0, rear_bumpers=0)
    assert robot.stalled
    assert robot.velocity == (0.0, 0.0)
    robot.set_contact(stalled=False, front_bumpers=0, rear_bumpers=0)
    robot.run_to(1.0 + 0.9 * STALL_PAUSE)
    assert robot.stalled
    assert robot.velocity == (0.0, 0.0)
    robot.run_to(1.0 + 2.0 * STALL_PAUSE)
    assert not robot.stalled
    assert robot.velocity[0] > 0.0


@pytest.mark.parametrize("setting", [0, 1, 2, 3])
def test_bumpers_count_as_a_stall_where_configured(setting: int) -> None:
    robot = base()
    robot.bump_stall = setting
    robot.set_contact(stalled=False, front_bumpers=1, rear_bumpers=0)
    assert robot.stalled == bool(setting & 1)
    robot.set_contact(stalled=False, front_bumpers=0, rear_bumpers=4)
    assert robot.stalled == bool(setting & 2)


def test_odometer_follows_arcs_and_ticks_follow_wheels() -> None:
    robot = base()
    for _ in range(90):
        robot.turn_odometer(math.pi / 180, math.pi / 180)  # a quarter of a circle of radius 1 m
    assert (robot.x, robot.y, robot.theta) == pytest.approx((1.0, 1.0, math.pi / 2), abs=1e-4)
    left, right = robot.ticks
    half_track = 1 / robot.model.turn
    assert left == pytest.approx(TICKS_PER_METRE * math.pi / 2 * (1 - half_track), abs=1)
    assert right == pytest.approx(TICKS_PER_METRE * math.pi / 2 * (1 + half_track), abs=1)


def test_ticks_wrap_at_32_bits() -> None:
    robot = base()
    robot.turn_odometer(2**31 / TICKS_PER_METRE, 0.0)
    assert robot.ticks == (-(2**31), -(2**31))


def test_a_new_session_starts_at_the_origin_with_the_limits_of_the_flash() -> None:
    robot = base()
    speed = robot.controller.limits.speed
    robot.controller.set_limit(Command(N.SETV, 200))
    robot.set_odometry(1.0, 2.0, 3.0)
    robot.close_session()
    robot.open_session()
    assert (robot.x, robot.y, robot.theta) == (0.0, 0.0, 0.0)
    assert robot.controller.limits.speed == speed


def test_battery_drains_while_time_passes() -> None:
    robot = base()
    full = robot.battery.volts
    robot.run_to(3600.0)
    assert robot.battery.volts == pytest.approx(full - 0.198, abs=0.001)

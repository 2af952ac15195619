from __future__ import annotations

from drivers.p2os.base_state import BaseState, base_state
from drivers.p2os.fitted_bumpers import FittedBumpers
from drivers.p2os.model import load_model
from drivers.p2os.motor_watch import MotorState, MotorWatch
from drivers.p2os.odometer import Odometer
from drivers.p2os.sip import decode_sip

IDLE = bytes.fromhex("32 00 00 00 00 00 00 00 00 00 00 80 00 00 00 00 00 00 00 00 05 00 00 FF 00")


def report(*, motors: bool, stalled: bool = False, button: bool = False) -> BaseState:
    data = bytearray(IDLE)
    data[12] = data[13] = stalled
    data[16] = motors | button << 5
    sip = decode_sip(bytes(data))
    assert sip is not None
    return base_state(0.0, sip, Odometer(), load_model("p2dx"), FittedBumpers((5, 5)))


def words_of(watch: MotorWatch, t: float) -> str:
    trouble = watch.trouble(t)
    assert trouble is not None
    return trouble.words


def running() -> MotorWatch:
    watch = MotorWatch()
    watch.update(report(motors=False), commands_pending=False)
    watch.on_enable(0.0)
    watch.update(report(motors=True), commands_pending=False)
    assert watch.state is MotorState.ON
    return watch


def test_motors_are_off_until_enabled_and_on_when_reported() -> None:
    watch = MotorWatch()
    assert watch.state is MotorState.UNKNOWN
    assert not watch.may_enable
    watch.update(report(motors=False), commands_pending=False)
    assert watch.state is MotorState.OFF
    assert watch.may_enable
    watch.on_enable(1.0)
    watch.update(report(motors=False), commands_pending=False)
    assert watch.state is MotorState.ENABLING
    watch.update(report(motors=True), commands_pending=True)
    assert watch.state is MotorState.ENABLING  # ENABLE has not left yet: not its answer
    watch.update(report(motors=True), commands_pending=False)
    assert watch.state is MotorState.ON
    assert watch.trouble(99.0) is None


def test_enable_is_repeated_and_then_reported_as_trouble() -> None:
    watch = MotorWatch()
    watch.update(report(motors=False), commands_pending=False)
    watch.on_enable(1.0)
    assert not watch.is_overdue(1.4)
    assert watch.is_overdue(1.5)
    watch.on_enable(1.5)
    assert not watch.is_overdue(1.9)
    assert watch.trouble(3.9) is None
    assert "motors do not come on" in words_of(watch, 4.1)


def test_motors_going_off_without_command_latch_the_stop_button() -> None:
    watch = running()
    watch.update(report(motors=False), commands_pending=False)
    assert watch.state is MotorState.STOP_BUTTON
    assert not watch.may_enable
    assert words_of(watch, 9.0) == "stopped by the robot's stop button: press MOTORS on the robot"
    watch.update(report(motors=False), commands_pending=False)
    assert watch.state is MotorState.STOP_BUTTON
    watch.update(report(motors=True), commands_pending=False)
    assert watch.state is MotorState.ON


def test_a_stall_is_not_a_stop_button() -> None:
    watch = running()
    watch.update(report(motors=False, stalled=True), commands_pending=False)
    assert watch.state is MotorState.OFF
    assert watch.may_enable


def test_held_button_is_in_the_trouble() -> None:
    watch = running()
    watch.update(report(motors=False, button=True), commands_pending=False)
    assert watch.state is MotorState.STOP_BUTTON
    assert "release it and press MOTORS" in words_of(watch, 0.0)
    watch.update(report(motors=False), commands_pending=False)
    assert watch.state is MotorState.STOP_BUTTON
    assert "release" not in words_of(watch, 0.0)

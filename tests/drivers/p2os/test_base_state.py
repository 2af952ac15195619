from __future__ import annotations

import math

import pytest

from drivers.p2os.base_state import BaseState, ChargeState, base_state
from drivers.p2os.fitted_bumpers import FittedBumpers
from drivers.p2os.model import load_model
from drivers.p2os.odometer import Odometer
from drivers.p2os.sip import decode_sip

HEAD = "33 00 00 00 00 00 00 C8 00 38 FF 7F {stall} 00 00 {flags} 00 00"
P2OS_TAIL = "05 00 00 FF 00"


def state(
    flags: str = "03 00",
    sonar: str = "00",
    tail: str = P2OS_TAIL,
    model: str = "p2dx",
    stall: str = "09 22",
) -> BaseState:
    head = HEAD.format(flags=flags, stall=stall).rsplit(" ", 1)[0]
    sip = decode_sip(bytes.fromhex(f"{head} {sonar} {tail}"))
    assert sip is not None
    return base_state(7.0, sip, Odometer(), load_model(model), FittedBumpers((5, 5)))


def test_p2os_report_is_converted_to_si() -> None:
    seen = state()
    assert (seen.t, seen.v_left, seen.v_right) == (7.0, 0.2, -0.2)
    assert seen.w == pytest.approx(-0.2 * 5.6)
    assert seen.battery == pytest.approx(12.7)
    assert (seen.stall_left, seen.stall_right) == (True, False)
    assert (seen.rear_bumpers, seen.front_bumpers) == (0b100, 0b10001)
    assert (seen.motors_enabled, seen.sonar_on, seen.stop_button) == (True, True, False)
    assert seen.moving
    assert not seen.standing


def test_fields_p2os_does_not_report_are_none() -> None:
    seen = state()
    assert seen.charge_state is seen.charge is seen.temperature_celsius is None
    assert seen.fault_flags == 0
    assert seen.turn_rate is None


def test_stall_by_the_stop_button_is_no_blocked_wheel() -> None:
    held = state(flags="61 04", stall="01 01")
    assert held.stop_button
    assert held.charger_power
    assert not held.stall_left
    assert not held.stall_right
    blocked = state(flags="01 00", stall="01 01")
    assert blocked.stall_left
    assert blocked.stall_right


def test_fields_of_later_firmware_are_converted() -> None:
    # 13.4 V, float charge, -30 deg/s, fault 2, no lateral speed, 31 degrees, 85 % charged
    seen = state(flags="21 00", tail=f"{P2OS_TAIL} 86 00 03 D4 FE 02 00 00 00 1F 55")
    assert seen.battery == pytest.approx(13.4)
    assert seen.charge_state is ChargeState.FLOAT
    assert seen.fault_flags == 2
    assert seen.turn_rate == pytest.approx(math.radians(-30.0))
    assert not seen.charger_power
    assert seen.temperature_celsius == 31
    assert seen.charge == pytest.approx(0.85)
    assert seen.stop_button
    assert not seen.sonar_on


@pytest.mark.parametrize("cold", ["80", "81"])
def test_unmeasured_temperature_is_none_and_undocumented_charge_state_is_unknown(cold: str) -> None:
    seen = state(tail=f"{P2OS_TAIL} 86 00 09 00 00 00 00 00 00 {cold} 00")
    assert seen.temperature_celsius is None
    assert seen.charge_state is ChargeState.UNKNOWN


@pytest.mark.parametrize(
    ("code", "charging"), [("00", False), ("01", True), ("04", True), ("05", True), ("FF", True)]
)
def test_any_charge_state_but_not_charging_counts_as_charging(code: str, charging: bool) -> None:
    assert state(tail=f"{P2OS_TAIL} 86 00 {code}").charging is charging


def test_base_that_reports_no_charge_state_is_not_charging() -> None:
    assert not state().charging
    assert not state(tail=f"{P2OS_TAIL} 86 00").charging


def test_readings_of_transducers_the_model_lacks_are_counted() -> None:
    seen = state(sonar="03 00 93 0E 10 93 0E 0F E1 48")
    assert seen.sonar == ((0, pytest.approx(0.9999, abs=1e-4)), (15, pytest.approx(5.0, abs=1e-3)))
    assert seen.unknown_sonars == 1


def test_battery_of_24_volts_is_on_the_scale_of_12_unless_the_firmware_sends_the_real_one() -> None:
    assert state(model="powerbot").battery == pytest.approx(25.4)
    assert state(model="powerbot", tail=f"{P2OS_TAIL} 05 01").battery == pytest.approx(26.1)


def test_voltage_that_no_12_volt_battery_has_is_taken_as_it_is(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(f"{__name__}.HEAD", HEAD.replace(" 7F ", " F0 "))
    assert state(model="powerbot").battery == pytest.approx(24.0)

from __future__ import annotations

import pytest

from drivers.p2os.emulator.battery import FULL, EmulatedBattery


def test_full_battery_is_empty_after_its_energy_is_used() -> None:
    battery = EmulatedBattery()
    assert battery.volts == FULL
    battery.drain(252.0 * 3600.0 / 25.0, 0.0)
    assert battery.volts == pytest.approx(FULL - 2.0)


def test_driving_either_way_drains_more_than_standing() -> None:
    standing, forward, backward = EmulatedBattery(), EmulatedBattery(), EmulatedBattery()
    standing.drain(60.0, 0.0)
    forward.drain(60.0, 30.0)
    backward.drain(60.0, -30.0)
    assert forward.volts == backward.volts < standing.volts < FULL


def test_voltage_can_be_set_and_never_falls_below_zero() -> None:
    battery = EmulatedBattery()
    battery.volts = 0.001
    battery.drain(1e6, 0.0)
    assert battery.volts == 0.0


def test_battery_of_24_volts_is_reported_also_as_one_of_12() -> None:
    battery = EmulatedBattery(24.0)
    battery.drain(3600.0, 0.0)
    assert 24.0 < battery.volts < 2.0 * FULL
    assert battery.reported_volts == battery.volts
    assert battery.reported_volts_of_12 == pytest.approx(battery.volts / 2.0)
    battery.fill()
    assert battery.volts == 2.0 * FULL

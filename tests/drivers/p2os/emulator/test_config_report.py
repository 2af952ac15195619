from __future__ import annotations

import math
from dataclasses import replace

import pytest

from drivers.p2os.command_numbers import CommandNumber
from drivers.p2os.commands import Command
from drivers.p2os.config_packet import AROS_FIELD_COUNT, LATER_FIELD_COUNT, decode_config
from drivers.p2os.emulator.base import EmulatedBase
from drivers.p2os.emulator.board import EmulatedBoard
from drivers.p2os.emulator.config_report import emulated_config
from drivers.p2os.emulator.firmware import Firmware
from drivers.p2os.emulator.make import PIONEER_2DX
from drivers.p2os.robot_identity import RobotIdentity

IDENTITY = RobotIdentity("R2", "Pioneer", "p2de")


def test_config_contains_identity_limits_settings_and_autobaud() -> None:
    base, board = EmulatedBase(PIONEER_2DX, 1.2), EmulatedBoard(PIONEER_2DX, Firmware.P2OS)
    limits = base.controller.limits
    limits.speed, limits.deceleration = 0.4, 0.55
    limits.turn_rate, limits.turn_acceleration = math.radians(90.0), math.radians(45.0)
    board.settings.set(Command(CommandNumber.REVCOUNT, 17000))
    config = emulated_config(IDENTITY, base, board, baud=38400)
    assert (config.robot_class, config.subclass, config.name) == ("Pioneer", "p2de", "R2")
    assert (config.speed_max, config.acceleration, config.deceleration) == (400, 300, 550)
    assert (config.turn_rate_max, config.turn_acceleration, config.turn_deceleration) == (
        90,
        45,
        100,
    )
    assert (config.watchdog_ms, config.sip_cycle_ms, config.host_baud_code) == (1200, 100, 2)
    assert config.autobaud == 2
    assert (config.front_bumper_segments, config.rear_bumper_segments) == (5, 5)
    assert config.revcount == 17000
    assert (config.low_battery_decivolts, config.stall_pwm, config.stall_pause_ms) == (
        115,
        200,
        100,
    )
    assert (config.turn_kp, config.turn_kv, config.turn_ki) == (20, 20, 0)
    assert (config.speed_kp, config.speed_kv, config.speed_ki) == (20, 20, 0)
    assert decode_config(config.encode()) == config


def test_config_contains_the_bumper_segments_of_the_make() -> None:
    make = replace(PIONEER_2DX, bumper_segments=(7, 0))
    board = EmulatedBoard(make, Firmware.P2OS)
    config = emulated_config(IDENTITY, EmulatedBase(make), board, baud=38400)
    assert (config.front_bumper_segments, config.rear_bumper_segments) == (7, 0)


@pytest.mark.parametrize(
    ("firmware", "fields"),
    [
        (Firmware.P2OS, LATER_FIELD_COUNT),
        (Firmware.AROS, AROS_FIELD_COUNT),
        (Firmware.ARCOS, LATER_FIELD_COUNT),
    ],
)
def test_config_is_as_long_as_the_firmware_makes_it(firmware: Firmware, fields: int) -> None:
    board = EmulatedBoard(PIONEER_2DX, firmware)
    config = emulated_config(IDENTITY, EmulatedBase(PIONEER_2DX), board, baud=9600)
    read = decode_config(config.encode())
    assert read is not None
    assert read.field_count == fields
    assert read.surplus == b""
    assert read.gyro_type == (firmware is not Firmware.P2OS)

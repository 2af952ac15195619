from __future__ import annotations

import math
from dataclasses import replace

from drivers.p2os.config_packet import LATER_FIELD_COUNT, decode_config
from drivers.p2os.emulator.config_report import emulated_config
from drivers.p2os.emulator.make import PIONEER_2DX
from drivers.p2os.emulator.motion_controller import limits_of
from drivers.p2os.robot_identity import RobotIdentity


def test_config_contains_identity_limits_and_autobaud() -> None:
    limits = limits_of(PIONEER_2DX)
    limits.speed, limits.deceleration = 0.4, 0.55
    limits.turn_rate, limits.turn_acceleration = math.radians(90.0), math.radians(45.0)
    identity = RobotIdentity("R2", "Pioneer", "p2de")
    config = emulated_config(identity, PIONEER_2DX, limits, baud=38400, watchdog=1.2)
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
    assert config.field_count == LATER_FIELD_COUNT
    assert decode_config(config.encode()) == config


def test_config_contains_the_bumper_segments_of_the_make() -> None:
    make = replace(PIONEER_2DX, bumper_segments=(7, 0))
    identity = RobotIdentity("R2", "Pioneer", "powerbot")
    config = emulated_config(identity, make, limits_of(make), baud=38400, watchdog=1.2)
    assert (config.front_bumper_segments, config.rear_bumper_segments) == (7, 0)

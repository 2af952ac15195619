"""The CONFIG packet of an emulated controller."""

from __future__ import annotations

import math
from dataclasses import asdict

from drivers.p2os.commands import HOST_BAUDS
from drivers.p2os.config_packet import ConfigPacket
from drivers.p2os.emulator.base import EmulatedBase
from drivers.p2os.emulator.board import EmulatedBoard
from drivers.p2os.robot_identity import RobotIdentity

SIP_CYCLE = 0.1  # s
SWITCHES_BAUD_AT_ONCE = 2


def emulated_config(
    identity: RobotIdentity,
    base: EmulatedBase,
    board: EmulatedBoard,
    *,
    baud: int,
) -> ConfigPacket:
    """Return the CONFIG, by the board's firmware, of a controller that starts at ``baud`` and
    supports HOSTBAUD; its limits and settings are those in force."""
    model, limits = base.model, base.controller.limits
    return ConfigPacket(
        robot_class=identity.robot_class,
        subclass=identity.subclass,
        serial_number="EMULATED",
        turn_rate_top=round(model.top_turn_rate_deg),
        speed_top=round(1000.0 * model.top_speed),
        turn_acceleration_top=300,
        acceleration_top=2000,
        pwm_max=500,
        name=identity.name,
        sip_cycle_ms=round(1000.0 * SIP_CYCLE),
        host_baud_code=HOST_BAUDS.index(baud),
        front_sonar=1,
        rear_sonar=1,
        watchdog_ms=round(1000.0 * base.watchdog),
        turn_rate_max=round(math.degrees(limits.turn_rate)),
        speed_max=round(1000.0 * limits.speed),
        turn_acceleration=round(math.degrees(limits.turn_acceleration)),
        turn_deceleration=round(math.degrees(limits.turn_deceleration)),
        acceleration=round(1000.0 * limits.acceleration),
        deceleration=round(1000.0 * limits.deceleration),
        front_bumper_segments=model.bumper_segments[0],
        rear_bumper_segments=model.bumper_segments[1],
        autobaud=SWITCHES_BAUD_AT_ONCE,
        gyro_type=int(board.firmware.has_gyro),
        firmware_version=board.firmware.version,
        **asdict(board.settings),
        field_count=board.firmware.config_fields,
    )

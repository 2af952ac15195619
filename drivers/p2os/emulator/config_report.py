"""The CONFIG packet of an emulated controller."""

from __future__ import annotations

import math

from drivers.p2os.commands import HOST_BAUDS
from drivers.p2os.config_packet import LATER_FIELD_COUNT, ConfigPacket
from drivers.p2os.emulator.base import STALL_PAUSE, TICKS_PER_METRE
from drivers.p2os.emulator.make import BaseMake
from drivers.p2os.emulator.motion_controller import MotionLimits
from drivers.p2os.robot_identity import RobotIdentity

SIP_CYCLE = 0.1  # s
SWITCHES_BAUD_AT_ONCE = 2


def emulated_config(
    identity: RobotIdentity,
    model: BaseMake,
    limits: MotionLimits,
    *,
    baud: int,
    watchdog: float,
) -> ConfigPacket:
    """Return the CONFIG of a controller that starts at ``baud`` and supports HOSTBAUD.

    limits: those in force. watchdog: s. It has the fields of later firmware, by which clients know
    that the rate can change.
    """
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
        watchdog_ms=round(1000.0 * watchdog),
        stall_pause_ms=round(1000.0 * STALL_PAUSE),
        turn_rate_max=round(math.degrees(limits.turn_rate)),
        speed_max=round(1000.0 * limits.speed),
        turn_acceleration=round(math.degrees(limits.turn_acceleration)),
        turn_deceleration=round(math.degrees(limits.turn_deceleration)),
        acceleration=round(1000.0 * limits.acceleration),
        deceleration=round(1000.0 * limits.deceleration),
        front_bumper_segments=model.bumper_segments[0],
        rear_bumper_segments=model.bumper_segments[1],
        ticks_per_mm=TICKS_PER_METRE // 1000,
        autobaud=SWITCHES_BAUD_AT_ONCE,
        field_count=LATER_FIELD_COUNT,
    )

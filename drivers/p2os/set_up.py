"""The commands that prepare a robot whose servers have just been opened."""

from __future__ import annotations

import math

from drivers.p2os.commands import STAND_STILL, STOP, Command, CommandNumber, command
from drivers.p2os.settings import BaseSettings

BUMP_STALL_CODES = {"off": 0, "front": 1, "rear": 2, "both": 3}


def set_up_commands(settings: BaseSettings) -> list[Command]:
    """Return limits, bumpers and sonar by the settings, then zero motion, in sending order."""
    return [
        command(CommandNumber.SETV, _whole_millimetres(settings.max_speed)),
        command(CommandNumber.SETRV, _whole_degrees(settings.max_turn_rate)),
        command(CommandNumber.SETA, _whole_millimetres(settings.acceleration)),
        command(CommandNumber.SETA, -_whole_millimetres(settings.deceleration)),
        command(CommandNumber.SETRA, _whole_degrees(settings.turn_acceleration)),
        command(CommandNumber.SETRA, -_whole_degrees(settings.turn_deceleration)),
        command(CommandNumber.BUMP_STALL, BUMP_STALL_CODES[settings.bump_stall]),
        command(CommandNumber.SONAR, 1),
        STOP,
        *STAND_STILL,
    ]


def _whole_millimetres(metres: float) -> int:
    return max(1, round(1000.0 * metres))


def _whole_degrees(radians: float) -> int:
    return max(1, round(math.degrees(radians)))

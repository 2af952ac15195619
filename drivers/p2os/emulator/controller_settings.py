"""Values of an emulated controller's FLASH that commands replace until its next reset."""

from __future__ import annotations

from dataclasses import dataclass

from drivers.p2os.command_numbers import CommandNumber
from drivers.p2os.commands import Command
from drivers.p2os.emulator.base import STALL_PAUSE, TICKS_PER_METRE
from drivers.p2os.emulator.sonar_firing import FIRING_PERIOD

_N = CommandNumber
_FIELDS = {
    _N.AUX1BAUD: "aux1_baud_code",
    _N.AUX2BAUD: "aux2_baud_code",
    _N.AUX3BAUD: "aux3_baud_code",
    _N.SONARCYCLE: "sonar_cycle_ms",
    _N.GYROCALCW: "gyro_clockwise",
    _N.GYROCALCCW: "gyro_counter_clockwise",
    _N.ROTKP: "turn_kp",
    _N.ROTKV: "turn_kv",
    _N.ROTKI: "turn_ki",
    _N.TRANSKP: "speed_kp",
    _N.TRANSKV: "speed_kv",
    _N.TRANSKI: "speed_ki",
    _N.REVCOUNT: "revcount",
    _N.DRIFTFACTOR: "drift_factor",
    _N.TICKSMM: "ticks_per_mm",
}
SETTERS = frozenset(_FIELDS)
"""Commands that replace a value."""
_SIGNED = ("drift_factor",)
_BYTES = ("aux1_baud_code", "aux2_baud_code", "aux3_baud_code", "sonar_cycle_ms")


@dataclass(slots=True)
class ControllerSettings:
    """The values, named and scaled as in CONFIG, where a client reads them back.

    They do not act on the emulated motion, whose servers follow their ramps exactly; the pause
    between two sonars does. Watchdog and revcount as dumps of real robots have them (rosaria #31),
    the rest ours.
    """

    low_battery_decivolts: int = 115
    shutdown_decivolts: int = 110
    revcount: int = 16570
    ticks_per_mm: int = TICKS_PER_METRE // 1000
    drift_factor: int = 0
    stall_pwm: int = 200
    stall_pause_ms: int = round(1000.0 * STALL_PAUSE)
    joystick_speed: int = 500
    joystick_turn_rate: int = 50
    turn_kp: int = 20
    turn_kv: int = 20
    turn_ki: int = 0
    speed_kp: int = 20
    speed_kv: int = 20
    speed_ki: int = 0
    sonar_cycle_ms: int = round(1000.0 * FIRING_PERIOD)
    aux1_baud_code: int = 0
    aux2_baud_code: int = 0
    aux3_baud_code: int = 0
    gyro_clockwise: int = 0
    gyro_counter_clockwise: int = 0

    def set(self, command: Command) -> None:
        """Replace the value that a command of SETTERS names; what its field cannot hold is cut."""
        name = _FIELDS[CommandNumber(command.number)]
        value = command.integer
        if name in _SIGNED:
            value = max(-0x8000, min(0x7FFF, value))
        else:
            value &= 0xFF if name in _BYTES else 0xFFFF
        setattr(self, name, value)

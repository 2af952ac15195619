"""The controller's operating systems, and what of each a client sees in its packets."""

from __future__ import annotations

from enum import StrEnum

from drivers.p2os.command_numbers import CommandNumber as N
from drivers.p2os.config_packet import AROS_FIELD_COUNT, LATER_FIELD_COUNT

UNKNOWN_TO_P2OS = frozenset(
    {
        *(N.JOYINFO, N.GYROCALCW, N.GYROCALCCW, N.SONARCYCLE, N.GYRO, N.BATTERYINFO, N.CALCOMP),
        *(N.AUX1BAUD, N.AUX2BAUD, N.AUX3BAUD, N.TTY3, N.TTY4, N.GETAUX2, N.GETAUX3, N.CHARGE),
        *(N.DRIFTFACTOR, N.SOUNDTOG, N.TICKSMM),
    }
)
"""Commands that AROS and ARCOS added (H8-series manual, Pioneer 3 manual)."""


class Firmware(StrEnum):
    """Operating system of a base's controller, oldest first."""

    P2OS = "p2os"  # Pioneer 2
    AROS = "aros"  # H8 boards
    ARCOS = "arcos"  # SH2 boards

    @property
    def tail_fields(self) -> int:
        """Number of fields behind the sonar readings of a SIP.

        P2OS ends with the digital outputs, AROS adds the battery's real voltage and the charge
        state (H8-series manual), ARCOS the turn rate and the faults (Pioneer 3 manual, ARIA).
        """
        return {Firmware.P2OS: 5, Firmware.AROS: 7, Firmware.ARCOS: 9}[self]

    @property
    def config_fields(self) -> int:
        """Number of fields of a CONFIG.

        An emulated P2OS sends those of ARCOS and obeys HOSTBAUD, BATTEST and RESET, ours: clients
        that change the rate can then be tried with every robot.
        """
        return AROS_FIELD_COUNT if self is Firmware.AROS else LATER_FIELD_COUNT

    def knows(self, number: int) -> bool:
        """Whether it may have a command of this number; it ignores the others."""
        return self is not Firmware.P2OS or number not in UNKNOWN_TO_P2OS

    @property
    def has_sonar_arrays(self) -> bool:
        """Whether each array of eight transducers has a switch and a flag of its own."""
        return self is not Firmware.P2OS

    @property
    def reports_stop_button(self) -> bool:
        """Whether the SIP's flags show stop button, stall by it and the charger's power."""
        return self is not Firmware.P2OS

    @property
    def has_gyro(self) -> bool:
        """Whether emulated robots with it have a gyro; ours: it is an option of every robot."""
        return self is not Firmware.P2OS

    @property
    def version(self) -> str:
        """Version as CONFIG states it; ours. P2OS has no such field."""
        return "2.0" if self is Firmware.ARCOS else ""

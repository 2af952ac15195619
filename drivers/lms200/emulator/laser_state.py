"""What an emulated LMS 200 holds: the settings it keeps without power, and its present mode."""

from __future__ import annotations

from dataclasses import dataclass, field

from drivers.lms200 import telegrams
from drivers.lms200.emulator.fields import MonitoredFields
from drivers.lms200.errors import Severity
from drivers.lms200.health import LaserHealth
from drivers.lms200.measurement import UNIT_MM
from drivers.lms200.telegrams import Configuration, Mode, Variant

POWER_ON_BAUD = 9600
EXTENDED_BYTES = 8  # of the extended configuration; its content is ours, all zero

_HEALTHY = LaserHealth(Severity.OK)
_TYPE = "LMS200;30106{};V02.10 "
_UNIT_DIGITS = {UNIT_MM: "1"}  # seen on a scanner of firmware V02.10: 3 in cm, 1 in mm


@dataclass(slots=True)
class LaserState:
    """An LMS 200's settings and condition; all but mode, baud and health are kept without power.

    type_text: what it answers to 3A, None for that of an LMS 200-30106. address: 1 to 127, or 0 for
    a laser without one. positioning_range: beams, 1-based, among which 69 looks for reflectors.
    """

    variant: Variant
    baud: int
    type_text: str | None = None
    address: int = 0
    configuration: Configuration = telegrams.STANDARD_CONFIGURATION
    extended: bytes = bytes(EXTENDED_BYTES)
    password: bytes = telegrams.PASSWORD
    permanent_baud: int = POWER_ON_BAUD
    fields: MonitoredFields = field(default_factory=MonitoredFields)
    positioning_range: tuple[int, int] | None = None
    variant_writes: int = 0
    configuration_writes: int = 0
    mode: Mode = Mode.ON_REQUEST
    health: LaserHealth = _HEALTHY

    @property
    def type(self) -> str:
        """The answer to 3A; its 13th character depends on the units."""
        if self.type_text is not None:
            return self.type_text
        return _TYPE.format(_UNIT_DIGITS.get(self.configuration.units, "3"))

    @property
    def software(self) -> str:
        """The version of its software, the end of the type."""
        return self.type.rsplit(";", 1)[-1]

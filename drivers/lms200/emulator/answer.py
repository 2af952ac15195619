"""What an emulated LMS 200 does upon a command."""

from __future__ import annotations

from dataclasses import dataclass

from drivers.lms200.emulator.measured_output import MeasuredOutput
from drivers.lms200.telegrams import Mode

MODE_CHANGE = 2.8  # s, of a laser that takes its time: 3 s at most in the listing
EEPROM_WRITE = 6.0  # s, of the same; clients allow 14 to 25 s


@dataclass(frozen=True, slots=True)
class Answer:
    """A command's consequences.

    reply: its reply without the status byte; empty where measured values are the reply. takes: s
    that a slow laser needs for it. baud_after: the rate once the reply has left. enter: the mode
    from then on. output: what to measure, in a mode continuously, else once. restarts: the laser is
    switched on anew.
    """

    reply: bytes = b""
    takes: float = 0.0
    baud_after: int | None = None
    enter: Mode | None = None
    output: MeasuredOutput | None = None
    restarts: bool = False

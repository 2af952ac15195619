"""The laser's error list: the B2 telegram and the meaning of its error numbers.

Source: SICK telegram listing 8007954/Q501, telegram B2 and error numbers.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from drivers.lms200.framing import Telegram
from drivers.lms200.telegrams import STATUS_OK, Command

_PAST = 0x80  # in the type byte: the error is no longer present


class Severity(IntEnum):
    """Severity: bits 0-2 of a status byte, and the type of an error entry."""

    OK = 0
    INFO = 1
    WARNING = 2
    ERROR = 3
    FATAL = 4


_SUBJECTS = {
    5: "dazzle test",
    6: "comparator",
    7: "comparator",
    17: "front window polluted",
    18: "front window polluted",
    19: "front window polluted",
    20: "front window polluted",
    21: "pollution reference",
    22: "pollution reference",
    29: "motor speed",
    45: "measured value missing",
    46: "scan missing",
    47: "laser power",
    49: "laser power",
    53: "flash memory",
    56: "watchdog",
    57: "no zero index",
    62: "DIP switch",
    124: "memory",
    125: "memory",
    126: "memory",
}


@dataclass(frozen=True, slots=True)
class ErrorEntry:
    """One entry of the error list."""

    severity: int  # a Severity; other numbers are passed on
    number: int
    present: bool

    @property
    def text(self) -> str:
        """The entry for people, e.g. ``warning 17: front window polluted``."""
        known = self.severity in Severity.__members__.values()
        kind = Severity(self.severity).name.lower() if known else f"type {self.severity}"
        subject = _SUBJECTS.get(self.number, "not in the listing")
        return f"{kind} {self.number}: {subject}" + ("" if self.present else " (past)")


def decode_errors(telegram: Telegram) -> tuple[ErrorEntry, ...]:
    """Return the entries of a B2 telegram; empty for a healthy laser."""
    data = telegram.payload[1:-1]
    return tuple(
        ErrorEntry(kind & ~_PAST, number, not kind & _PAST)
        for kind, number in zip(data[0::2], data[1::2], strict=False)
    )


def encode_errors(errors: tuple[ErrorEntry, ...]) -> bytes:
    """Return the B2 payload."""
    pairs = [(e.severity | (0 if e.present else _PAST), e.number) for e in errors]
    return bytes((Command.ERRORS.reply, *(octet for pair in pairs for octet in pair), STATUS_OK))

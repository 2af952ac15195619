"""Commands to SOPAS scanners and the content of their replies, but for measured values.

A command has a kind (read, write, method, event) and a name; its reply has another kind and the
same name. Angles are in ten-thousandths of a degree, of the scanner's own: 0 right, 90 ahead.
Measured values are in ``measurement.py``. Source: SICK "Telegram Listing" 8014631.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import IntEnum
from typing import ClassVar

from drivers.lms1xx.fields import FieldError, FieldReader, FieldWriter, fields_of
from drivers.lms1xx.framing import Dialect, Telegram

PER_DEGREE = 10000
PER_HERTZ = 100

LOGGED_IN = 1  # first field of the reply to LOGIN and LOGOUT; 0 is refused
DONE = 0  # first field of the reply to SET_SCANNING and START_MEASURING; others are refusals
CLIENT_LEVEL = 3
CLIENT_PASSWORD = 0xF4724744  # "client", of LMS 1xx, LMS 5xx and TiM5xx as delivered

LOGIN = "sMN SetAccessMode"
LOGOUT = "sMN Run"
READ_IDENTITY = "sRN DeviceIdent"
READ_CONTAMINATION = "sRN LCMstate"
READ_SCANNING = "sRN LMPscancfg"
SET_SCANNING = "sMN mLMPsetscancfg"
READ_RANGE = "sRN LMPoutputRange"
SET_RANGE = "sWN LMPoutputRange"
READ_CONTENT = "sRN LMDscandatacfg"
SET_CONTENT = "sWN LMDscandatacfg"
START_MEASURING = "sMN LMCstartmeas"
STOP_MEASURING = "sMN LMCstopmeas"
READ_SCAN = "sRN LMDscandata"
STREAM = "sEN LMDscandata"
SCAN_READ = "sRA LMDscandata"
SCAN_SENT = "sSN LMDscandata"
READ_DIALECT = "sRN EIHstCola"
SET_DIALECT = "sWN EIHstCola"

_REPLY_KINDS = {"sRN": "sRA", "sWN": "sWA", "sMN": "sAN", "sEN": "sEA"}
_FAULT = b"sFA"


class Fault(IntEnum):
    """Reasons of a refusal, as far as they are told apart."""

    ACCESS_DENIED = 0x01
    UNKNOWN_METHOD = 0x02
    UNKNOWN_VARIABLE = 0x03
    INVALID_DATA = 0x05
    WRITE_DENIED = 0x0A
    UNKNOWN_COMMAND = 0x0C


class Contamination(IntEnum):
    """State of the front window: value of LCMstate."""

    NONE = 0
    WARNING = 1
    ERROR = 2
    DEFECT = 3  # of its measurement


def reply_to(command: str) -> str:
    """Return kind and name of the reply to a command; "" for what is none."""
    kind, _, name = command.partition(" ")
    return f"{_REPLY_KINDS[kind]} {name}" if kind in _REPLY_KINDS else ""


def bare(command: str, dialect: Dialect) -> bytes:
    """Return the payload of a command without fields."""
    return FieldWriter(command, dialect).payload


def switch(command: str, dialect: Dialect, number: int) -> bytes:
    """Return the payload of a command or reply with one field of a byte."""
    return FieldWriter(command, dialect).unsigned(number, 1).payload


def login(dialect: Dialect) -> bytes:
    """Return the payload that logs in as authorised client."""
    writer = FieldWriter(LOGIN, dialect)
    if dialect is Dialect.A:  # as in the listing's example, to the letter
        return writer.fixed_text(f"{CLIENT_LEVEL:02X}").unsigned(CLIENT_PASSWORD, 4).payload
    return writer.unsigned(CLIENT_LEVEL, 1).unsigned(CLIENT_PASSWORD, 4).payload


def decode_byte(telegram: Telegram) -> int | None:
    """Return the first field, one byte: a result, a state; None without it."""
    try:
        return fields_of(telegram).unsigned(1)
    except FieldError:
        return None


def decode_identity(telegram: Telegram) -> str | None:
    """Return name and version of a DeviceIdent reply; None if it is unreadable."""
    fields = fields_of(telegram)
    try:
        return f"{fields.text().strip()} {fields.text().strip()}"
    except FieldError:
        return None


def decode_fault(telegram: Telegram) -> int | None:
    """Return the number of an error reply, a ``Fault`` or another; None for any other telegram."""
    payload = telegram.payload
    if not payload.startswith(_FAULT):
        return None
    behind = payload[len(_FAULT) :]
    if telegram.dialect is Dialect.B and len(behind) == 2:  # in CoLa B without the space
        return int.from_bytes(behind, "big")
    try:
        return fields_of(Telegram(telegram.dialect, b"sFA -" + behind)).unsigned(2)
    except FieldError:
        return 0


def encode_fault(fault: Fault, dialect: Dialect) -> bytes:
    """Return the payload of an error reply."""
    if dialect is Dialect.A:
        return FieldWriter("sFA", dialect).unsigned(fault, 2).payload
    return _FAULT + fault.to_bytes(2, "big")


@dataclass(frozen=True, slots=True)
class Scanning:
    """How the scanner measures: LMPscancfg and mLMPsetscancfg; one sector, no more is sent."""

    frequency: int  # hundredths of a hertz
    resolution: int
    first: int
    last: int

    @classmethod
    def decode(cls, telegram: Telegram) -> Scanning | None:
        """Decode a reading, or a host's setting; None if it is unreadable."""
        try:
            return cls._take(fields_of(telegram))
        except FieldError:
            return None

    @classmethod
    def decode_set(cls, telegram: Telegram) -> tuple[int, Scanning] | None:
        """Decode the reply to a setting: 0 for accepted, and what is set now; None as above."""
        fields = fields_of(telegram)
        try:
            return fields.unsigned(1), cls._take(fields)
        except FieldError:
            return None

    @classmethod
    def _take(cls, fields: FieldReader) -> Scanning:
        frequency, _sectors = fields.signed(4), fields.signed(2)
        return cls(frequency, fields.unsigned(4), fields.signed(4), fields.signed(4))

    def write(self, writer: FieldWriter) -> FieldWriter:
        """Add the fields."""
        writer.unsigned(self.frequency, 4).unsigned(1, 2).unsigned(self.resolution, 4)
        return writer.signed(self.first, 4).signed(self.last, 4)


@dataclass(frozen=True, slots=True)
class OutputRange:
    """Which of the measured values are sent: LMPoutputRange."""

    ROUNDING: ClassVar = 100  # by which a scanner may move the ends; an LMS 111 does by 3

    resolution: int
    first: int
    last: int

    def fits(self, other: OutputRange) -> bool:
        """Whether both are the same within ROUNDING."""
        ends = max(abs(self.first - other.first), abs(self.last - other.last))
        return self.resolution == other.resolution and ends <= self.ROUNDING

    @classmethod
    def decode(cls, telegram: Telegram) -> OutputRange | None:
        """Decode a reading, or a host's setting; None if it is unreadable."""
        fields = fields_of(telegram)
        try:
            fields.unsigned(2)  # number of sectors: one
            return cls(fields.unsigned(4), fields.signed(4), fields.signed(4))
        except FieldError:
            return None

    def write(self, writer: FieldWriter) -> FieldWriter:
        """Add the fields."""
        writer.unsigned(1, 2).unsigned(self.resolution, 4)
        return writer.signed(self.first, 4).signed(self.last, 4)


@dataclass(frozen=True, slots=True)
class ScanContent:
    """What each telegram of measured values holds: LMDscandatacfg.

    echoes: bit 0 for the first, bit 1 for the second (or last). wide: remission in 16 bits, not
    8. every: of so many scans one is sent.
    """

    FIRST_ECHO: ClassVar = 0x01
    SECOND_ECHO: ClassVar = 0x02

    echoes: int = FIRST_ECHO
    remission: bool = False
    wide: bool = False
    encoder: int = 0
    position: bool = False
    name: bool = False
    comment: bool = False
    time: bool = False
    every: int = 1

    def for_ranges(self) -> ScanContent:
        """Return the content that has the ranges of the first echo in every scan, no remission."""
        return replace(self, echoes=self.FIRST_ECHO, remission=False, every=1)

    @classmethod
    def decode(cls, telegram: Telegram) -> ScanContent | None:
        """Decode a reading, or a host's setting; None if it is unreadable."""
        fields = fields_of(telegram)
        try:
            echoes, _high = fields.unsigned(1), fields.unsigned(1)
            remission, wide, _unit = (fields.unsigned(1) for _ in range(3))
            encoder, _encoder_high = fields.unsigned(1), fields.unsigned(1)
            position, name, comment, time = (fields.unsigned(1) != 0 for _ in range(4))
            every = fields.unsigned(2)
        except FieldError:
            return None
        return cls(echoes, remission != 0, wide != 0, encoder, position, name, comment, time, every)

    def write(self, writer: FieldWriter) -> FieldWriter:
        """Add the fields."""
        flags = (self.remission, self.wide, False)
        for number in (self.echoes, 0, *flags, self.encoder, 0):
            writer.unsigned(int(number), 1)
        for flag in (self.position, self.name, self.comment, self.time):
            writer.unsigned(int(flag), 1)
        return writer.unsigned(self.every, 2)

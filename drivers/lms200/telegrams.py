"""Commands to the LMS 200 and the content of its replies, but for measured values.

Payloads are command and data, unframed; replies end with the status byte. Measured values are in
``measurement.py``.
Source: SICK telegram listing 8007954/Q501, commands and status telegram.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import IntEnum

from drivers.lms200.framing import REPLY_BIT, Telegram

PASSWORD = b"SICK_LMS"
STATUS_OK = 0x10  # status byte of a healthy LMS type 6
ACCEPTED = 1  # first data byte of BB and F7; 0 is refused
MODE_SELECTED = 0  # first data byte of A0; anything else is a failure
WRONG_PASSWORD = 1
MODE_FAULT = 2


class Command(IntEnum):
    """Command codes; the reply's code has bit 7 set."""

    RESET = 0x10
    MODE = 0x20
    REQUEST = 0x30
    STATUS = 0x31
    ERRORS = 0x32
    OPERATING_HOURS = 0x35
    MEAN_VALUES = 0x36
    SUB_RANGE = 0x37
    TYPE = 0x3A
    VARIANT = 0x3B
    FIELD_VALUES = 0x3E  # of a sub-range
    MEAN_SUB_RANGE = 0x3F
    WRITE_FIELD = 0x40
    FIELD_SET = 0x41
    PASSWORD = 0x42
    RANGES_AND_REFLECTIVITY = 0x44  # reflectivity of a sub-range
    READ_FIELD = 0x45
    TEACH_FIELD = 0x46
    FIELD_OUTPUTS = 0x4A
    PERMANENT_BAUD = 0x66
    POSITIONING_AID = 0x69
    POSITIONING_RANGE = 0x6A
    READ_CONFIGURATION = 0x74
    REFLECTIVITY_PARTS = 0x75  # pairs of range and reflectivity, of several sub-ranges
    CARTESIAN = 0x76
    WRITE_CONFIGURATION = 0x77
    WRITE_EXTENDED = 0x7B
    READ_EXTENDED = 0x7C

    @property
    def reply(self) -> int:
        """Code of the reply to this command."""
        return self | REPLY_BIT


POWER_ON = 0x90
RESET_CONFIRMED = 0x91
BAD_COMMAND = 0x92
MEASURED_VALUES = 0xB0


class Mode(IntEnum):
    """Operating modes selected with ``Command.MODE``."""

    INSTALLATION = 0x00
    DIAGNOSTIC = 0x10
    SEGMENTS = 0x20  # the smallest value of each segment
    SEGMENTS_INFRINGED = 0x21  # the same, while a field is infringed
    DEPTHS = 0x22  # the smallest distance from the laser's baseline
    DEPTHS_INFRINGED = 0x23
    CONTINUOUS = 0x24
    ON_REQUEST = 0x25
    MEANS = 0x26
    SUB_RANGE = 0x27
    MEANS_OF_SUB_RANGE = 0x28
    FIELD_VALUES = 0x29
    CONTINUOUS_TURNS = 0x2A  # each mirror turn by itself: partial scans
    REFLECTIVITY_PARTS = 0x2B  # range and reflectivity of several sub-ranges
    SUB_RANGE_MINIMA = 0x2C
    NAVIGATION = 0x2E
    TEST_PASSWORD = 0x30
    RANGES_AND_REFLECTIVITY = 0x50


BAUD_MODES = {38400: 0x40, 19200: 0x41, 9600: 0x42, 500000: 0x48}
_BAUD_WORDS = {500000: 0x8001, 38400: 0x8019, 19200: 0x8033, 9600: 0x8067}

SELECT_CONTINUOUS = bytes((Command.MODE, Mode.CONTINUOUS))
SELECT_CONTINUOUS_TURNS = bytes((Command.MODE, Mode.CONTINUOUS_TURNS))
SELECT_ON_REQUEST = bytes((Command.MODE, Mode.ON_REQUEST))
SELECT_INSTALLATION = bytes((Command.MODE, Mode.INSTALLATION)) + PASSWORD
READ_TYPE = bytes((Command.TYPE,))
READ_STATUS = bytes((Command.STATUS,))
READ_ERRORS = bytes((Command.ERRORS,))
READ_CONFIGURATION = bytes((Command.READ_CONFIGURATION,))


def select_baud(baud: int) -> bytes:
    """Return the command for 9600, 19200, 38400 or 500000 baud; KeyError for any other."""
    return bytes((Command.MODE, BAUD_MODES[baud]))


@dataclass(frozen=True, slots=True)
class Variant:
    """Field of view in degrees and angular step in hundredths of a degree."""

    angle_deg: int
    resolution_cdeg: int

    def encode(self) -> bytes:
        """Return angle and resolution as encoded in the 3B command and the BB reply."""
        return struct.pack("<HH", self.angle_deg, self.resolution_cdeg)

    @property
    def count(self) -> int:
        """Values per scan."""
        return self.angle_deg * 100 // self.resolution_cdeg + 1

    @property
    def mirror_turns(self) -> int:
        """Mirror turns that make up one scan: each gives steps of 1 degree."""
        return 100 // self.resolution_cdeg


VARIANTS = (
    Variant(180, 100),
    Variant(180, 50),
    Variant(100, 100),
    Variant(100, 50),
    Variant(100, 25),
)


def set_variant(variant: Variant) -> bytes:
    """Return the 3B command."""
    return bytes((Command.VARIANT,)) + variant.encode()


@dataclass(frozen=True, slots=True)
class VariantReply:
    """BB: whether the variant was taken, and the variant now in force."""

    accepted: bool
    variant: Variant

    @classmethod
    def decode(cls, telegram: Telegram) -> VariantReply | None:
        """Decode a BB telegram; None if it is too short."""
        if len(telegram.payload) < 6:
            return None
        status, angle, resolution = struct.unpack_from("<BHH", telegram.payload, 1)
        return cls(status == ACCEPTED, Variant(angle, resolution))

    def encode(self) -> bytes:
        """Return the BB payload."""
        head = bytes((Command.VARIANT.reply, int(self.accepted)))
        return head + self.variant.encode() + bytes((STATUS_OK,))


def first_data_byte(telegram: Telegram) -> int | None:
    """Return the result byte of A0, BB or F7; None where there is none."""
    return telegram.payload[1] if len(telegram.payload) > 1 else None


def encode_text(code: int, text: str) -> bytes:
    """Return a reply that carries text: type (BA) or power-on (90)."""
    return bytes((code,)) + text.encode("ascii") + bytes((STATUS_OK,))


def decode_text(telegram: Telegram) -> str:
    """Return the text of a type or power-on telegram, without padding."""
    return telegram.payload[1:-1].decode("ascii", errors="replace").strip(" \0")


@dataclass(frozen=True, slots=True)
class DeviceStatus:
    """The fields of B1 that a driver needs; offsets count from the reply code."""

    LENGTH = 154  # reply code, 152 data bytes, status byte
    SHORTEST = 124  # up to and with the units, and a status byte: firmware may send less

    software: str
    mode: int
    defective: bool
    measuring_mode: int
    variant: Variant
    baud: int | None
    units: int
    permanent_baud: bool = False

    @classmethod
    def decode(cls, telegram: Telegram) -> DeviceStatus | None:
        """Decode a B1 telegram; None if it is too short to hold the units."""
        payload = telegram.payload
        if len(payload) < cls.SHORTEST:
            return None
        (baud_word,) = struct.unpack_from("<H", payload, 116)
        return cls(
            software=payload[1:8].decode("ascii", errors="replace").strip(" \0"),
            mode=payload[8],
            defective=payload[9] > 0,
            measuring_mode=payload[102],
            variant=Variant(*struct.unpack_from("<HH", payload, 107)),
            baud=next((baud for baud, word in _BAUD_WORDS.items() if word == baud_word), None),
            units=payload[122],
            permanent_baud=payload[119] > 0,
        )

    def encode(self) -> bytes:
        """Return the B1 payload; fields not held here are zero."""
        payload = bytearray(self.LENGTH)
        payload[0] = Command.STATUS.reply
        payload[1:8] = self.software.encode("ascii")[:7].ljust(7)
        payload[8] = self.mode
        payload[9] = int(self.defective)
        payload[102] = self.measuring_mode
        payload[107:111] = self.variant.encode()
        struct.pack_into("<H", payload, 116, _BAUD_WORDS[self.baud] if self.baud else 0)
        payload[119] = int(self.permanent_baud)
        payload[122] = self.units
        payload[-1] = STATUS_OK
        return bytes(payload)


@dataclass(frozen=True, slots=True)
class Configuration:
    """The configuration block of 74 and 77; its length differs by firmware, 34 in the listing.

    Only units and measuring mode are ever changed; the rest is written back as it was read.
    """

    SHORTEST = 7  # up to and with the units, as the shortest known 77 sends
    LONGEST = 64

    block: bytes

    @classmethod
    def decode(cls, block: bytes) -> Configuration | None:
        """Check a block; None if it is shorter than SHORTEST or longer than LONGEST."""
        return cls(block) if cls.SHORTEST <= len(block) <= cls.LONGEST else None

    @property
    def measuring_mode(self) -> int:
        """Code of the measuring mode (``measurement.MEASURING_MODES``)."""
        return self.block[5]

    @property
    def units(self) -> int:
        """Code of the units: 0 cm, 1 mm."""
        return self.block[6]

    @property
    def evaluations(self) -> int:
        """Scans in a row that must find a field infringed."""
        return self.block[9] if len(self.block) > 9 else 1

    @property
    def sends_indices(self) -> bool:
        """Whether scan and telegram index follow the values of B0."""
        return bool(self.block[4] & 0x02)

    def changed(self, measuring_mode: int, units: int) -> Configuration:
        """Return the same block with these two fields set."""
        return Configuration(self.block[:5] + bytes((measuring_mode, units)) + self.block[7:])

    def overlaid(self, block: bytes) -> Configuration:
        """Return this block with its first bytes replaced by ``block``, as a shorter 77 does."""
        return Configuration(block + self.block[len(block) :])


STANDARD_CONFIGURATION = Configuration(
    bytes.fromhex(
        "0000 46 00 00 00 01 00 00 02 02 02 00"  # blanking to second multiple evaluation
        "00 0A 0A 50 64 00 0A 0A 50 80 00 0A 0A 50 64 00 00 00 00 02 00"  # contours, the rest
    )
)


def write_configuration(configuration: Configuration) -> bytes:
    """Return the 77 command."""
    return bytes((Command.WRITE_CONFIGURATION,)) + configuration.block


def decode_read_configuration(telegram: Telegram) -> Configuration | None:
    """Return the configuration in an F4 telegram; None if it is unusable."""
    return Configuration.decode(telegram.payload[1:-1])

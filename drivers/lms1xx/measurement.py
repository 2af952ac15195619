"""Measured values of SOPAS scanners: LMDscandata with its channels.

Source: SICK "Telegram Listing" 8014631, LMDscandata; values below 16 are no ranges: operating
instructions of the LMS4000 (8023198), reserved values.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivers.lms1xx.fields import FieldError, FieldReader, FieldWriter, fields_of
from drivers.lms1xx.framing import Dialect, Telegram

SMALLEST_RANGE = 16  # counts; below there are other meanings
NO_RETURN = 0
DAZZLED = 1

STATUS_ERROR = 0x01
STATUS_CONTAMINATION_WARNING = 0x02
STATUS_CONTAMINATION_ERROR = 0x04

_MOST = 8  # encoders or channels; more are announced by noise


@dataclass(frozen=True, slots=True, eq=False)
class Channel:
    """One value per beam: DIST1, DIST2 (ranges of the first and second echo), RSSI1, RSSI2.

    counts (n,): unsigned, 16 or 8 bit; a range in mm is scale * count + offset. first, step:
    ten-thousandths of a degree, of the scanner's own.
    """

    content: str
    scale: float
    offset: float
    first: int
    step: int
    counts: NDArray[np.integer]

    @classmethod
    def take(cls, fields: FieldReader, size: int) -> Channel:
        """Take a channel with values of ``size`` bytes; FieldError where there is none."""
        content = fields.fixed_text(5)
        scale, offset = fields.real(), fields.real()
        first, step, count = fields.signed(4), fields.unsigned(2), fields.unsigned(2)
        return cls(content, scale, offset, first, step, fields.values(count, size))

    def write(self, writer: FieldWriter, size: int) -> None:
        """Add the channel with values of ``size`` bytes."""
        writer.fixed_text(self.content).real(self.scale).real(self.offset)
        writer.signed(self.first, 4).unsigned(self.step, 2).unsigned(len(self.counts), 2)
        writer.values(self.counts, size)


@dataclass(frozen=True, slots=True, eq=False)
class Measurement:
    """The content of one telegram of measured values.

    status: bits as STATUS_*; 0 is healthy. telegrams, scans: counters. counted, sent: the
    scanner's clock, microseconds modulo 2^32, at the scan's own mark and when its data left.
    frequency: of scans, hundredths of a hertz. wide, narrow: channels of 16 and of 8 bits.
    """

    serial: int
    status: int
    telegrams: int
    scans: int
    counted: int
    sent: int
    frequency: int
    wide: tuple[Channel, ...]
    narrow: tuple[Channel, ...] = ()

    def channel(self, content: str) -> Channel | None:
        """Return the channel of this content, None without one."""
        for each in (*self.wide, *self.narrow):
            if each.content == content:
                return each
        return None


def decode_measurement(telegram: Telegram) -> Measurement | None:
    """Decode a telegram of measured values; None if it is unreadable. Ends with the channels."""
    try:
        return _take(fields_of(telegram))
    except FieldError:
        return None


def _take(fields: FieldReader) -> Measurement:
    _version, _device, serial = fields.unsigned(2), fields.unsigned(2), fields.unsigned(4)
    _unused, status = fields.unsigned(1), fields.unsigned(1)
    telegrams, scans = fields.unsigned(2), fields.unsigned(2)
    counted, sent = fields.unsigned(4), fields.unsigned(4)
    for _inputs_and_outputs in range(4):
        fields.unsigned(1)
    _layer, frequency, _measurements = fields.unsigned(2), fields.unsigned(4), fields.unsigned(4)
    for _encoder in range(_number(fields)):
        fields.unsigned(4)  # position
        fields.unsigned(2)  # speed
    wide = tuple(Channel.take(fields, 2) for _ in range(_number(fields)))
    narrow = tuple(Channel.take(fields, 1) for _ in range(_number(fields)))
    return Measurement(serial, status, telegrams, scans, counted, sent, frequency, wide, narrow)


def _number(fields: FieldReader) -> int:
    number = fields.unsigned(2)
    if number > _MOST:
        raise FieldError("more than any scanner has")
    return number


def encode_measurement(measurement: Measurement, command: str, dialect: Dialect) -> bytes:
    """Return the payload; ``command`` is SCAN_SENT or SCAN_READ. No position, name or time."""
    writer = FieldWriter(command, dialect)
    writer.unsigned(1, 2).unsigned(1, 2).unsigned(measurement.serial, 4)
    writer.unsigned(0, 1).unsigned(measurement.status, 1)
    writer.unsigned(measurement.telegrams, 2).unsigned(measurement.scans, 2)
    writer.unsigned(measurement.counted, 4).unsigned(measurement.sent, 4)
    for _inputs_and_outputs in range(4):
        writer.unsigned(0, 1)
    writer.unsigned(0, 2).unsigned(measurement.frequency, 4)
    beams = len(measurement.wide[0].counts) if measurement.wide else 0
    writer.unsigned(beams * measurement.frequency // 10000, 4)  # hundreds of hertz
    writer.unsigned(0, 2)  # encoders
    for channels, size in ((measurement.wide, 2), (measurement.narrow, 1)):
        writer.unsigned(len(channels), 2)
        for channel in channels:
            channel.write(writer, size)
    for _position_name_comment_time_event in range(5):
        writer.unsigned(0, 2)
    return writer.payload

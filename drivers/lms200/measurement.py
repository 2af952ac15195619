"""Measured values of the LMS 200: the B0 telegram, its units, value bits and special values.

Source: SICK telegram listing 8007954/Q501, telegram B0 and measuring modes.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivers.lms200.framing import Telegram
from drivers.lms200.telegrams import MEASURED_VALUES, Variant
from drivers.scan import Special

TURN = 13.32e-3  # s, one mirror turn; half of it faces the scene

UNIT_CM = 0
UNIT_MM = 1
_METRES = {0: 0.01, 1: 0.001, 2: 0.1}  # by bits 14-15 of the count word

_COUNT_MASK = 0x03FF
_PARTIAL = 0x2000
_QUARTER_SHIFT = 11
_FLAG_SHIFT = 13  # the lowest bit that is a flag in any mode


@dataclass(frozen=True, slots=True)
class MeasuringMode:
    """Division of a 16-bit value into distance and flags."""

    mask: int  # the distance bits
    no_return: int  # the largest special value
    reflector_bits: int = 0  # the flags that hold the reflector level

    @property
    def limit(self) -> int:
        """The smallest special value, "beyond maximum"; only values below it are distances."""
        return self.no_return - Special.NO_RETURN + Special.BEYOND_MAXIMUM

    @property
    def flag_bits(self) -> int:
        """The flags the mode has, of bits 13 to 15 shifted down to 0 to 2."""
        return (~self.mask & 0xFFFF) >> _FLAG_SHIFT


MEASURING_MODES: dict[int, MeasuringMode] = {
    0x00: MeasuringMode(0x1FFF, 0x1FFF),  # 8 m in mm, 80 m in cm; flags: fields A and B, dazzle
    0x01: MeasuringMode(0x1FFF, 0x1FFF, 0b111),  # flags: reflector in 8 levels
    0x02: MeasuringMode(0x1FFF, 0x1FFF),  # flags: fields A, B, C
    0x03: MeasuringMode(0x3FFF, 0x3FFF, 0b110),  # 16 m; flags: reflector in 4 levels
    0x04: MeasuringMode(0x3FFF, 0x3FFF),  # flags: fields A, B
    0x05: MeasuringMode(0x7FFF, 0x7FFF, 0b100),  # 32 m; flag: reflector
    0x06: MeasuringMode(0x7FFF, 0x7FFF),  # flag: field A
    0x0D: MeasuringMode(0xFFFF, 0x7FFF),  # 32 m, no flags; reflectivity in 2B normalized
    0x0E: MeasuringMode(0xFFFF, 0x7FFF),  # the same, reflectivity as measured
    0x0F: MeasuringMode(0xFFFF, 0x7FFF),  # 32 m sent at once, no flags
}
MODE_32_M = 0x05
MODE_REFLECTIVITY = 0x0E


@dataclass(frozen=True, slots=True, eq=False)
class Measurement:
    """The content of one B0 telegram, geometry and units resolved; arrays are by beam, (n,).

    ranges: float64 m, inf where there is none. specials: uint8, a ``Special`` each (numbers in
    between are reserved). flags: uint8, the mode's flags in bits 0 to 2. reflectors: bool, or None
    where the mode has no reflector bits. The first beam is the rightmost, at ``first_deg``
    (0 right, 90 ahead, 180 left), the next ``step_deg`` to its left. scans: number averaged.
    remission: uint16, what the beam's end reflected, up to some 13000; None where it is not sent.
    """

    ranges: NDArray[np.float64]
    specials: NDArray[np.uint8]
    flags: NDArray[np.uint8]
    reflectors: NDArray[np.bool_] | None
    first_deg: float
    step_deg: float
    mirror_turns: int
    status: int
    scans: int = 1
    remission: NDArray[np.uint16] | None = None


_VARIANT_BY_COUNT = {
    181: Variant(180, 100),
    361: Variant(180, 50),
    101: Variant(100, 100),
    201: Variant(100, 50),
    401: Variant(100, 25),
}
_PARTIAL_COUNTS = (181, 180)  # one turn, always the whole 180 degrees: at .00, at the others


def decode_measurement(telegram: Telegram, mode: MeasuringMode) -> Measurement | None:
    """Decode a B0 telegram; None if it is no whole scan or its length differs from its count."""
    payload = telegram.payload
    if telegram.code != MEASURED_VALUES or len(payload) < 4:
        return None
    word = payload[1] | payload[2] << 8
    count = word & _COUNT_MASK
    metres = _METRES.get(word >> 14)
    geometry = _geometry(count, word)
    without_indices = 3 + 2 * count + 1
    if metres is None or geometry is None:
        return None
    if len(payload) not in (without_indices, without_indices + 2):
        return None
    raw = np.frombuffer(payload, "<u2", count, offset=3)
    values = decode_values(raw, mode, metres)
    return Measurement(*values, *geometry, status=payload[-1])


DecodedValues = tuple[
    NDArray[np.float64], NDArray[np.uint8], NDArray[np.uint8], NDArray[np.bool_] | None
]
"""Ranges, specials, flags and reflectors of a ``Measurement``."""


def decode_values(raw: NDArray[np.uint16], mode: MeasuringMode, metres: float) -> DecodedValues:
    """Return what values (n,) as they are sent mean; metres: the unit."""
    values = raw & mode.mask
    largest = mode.limit - 1
    specials = (np.clip(values, largest, largest + 255) - largest).astype(np.uint8)
    ranges = np.multiply(values, metres, dtype=np.float64)
    ranges[specials != Special.RANGE] = np.inf
    flags = (raw >> _FLAG_SHIFT).astype(np.uint8) & np.uint8(mode.flag_bits)
    reflectors = (flags & mode.reflector_bits) != 0 if mode.reflector_bits else None
    return ranges, specials, flags, reflectors


def read_count_word(payload: bytes, at: int) -> tuple[int, float | None]:
    """Return the number of values and their unit, m; None for no unit."""
    word = payload[at] | payload[at + 1] << 8
    return word & _COUNT_MASK, _METRES.get(word >> 14)


def _geometry(count: int, word: int) -> tuple[float, float, int] | None:
    """Return first beam (deg), step (deg) and mirror turns; None if no scan has this count."""
    if word & _PARTIAL:
        quarter_deg = 0.25 * (word >> _QUARTER_SHIFT & 0b11)
        return (quarter_deg, 1.0, 1) if count in _PARTIAL_COUNTS else None
    variant = _VARIANT_BY_COUNT.get(count)
    if variant is None:
        return None
    first_deg = 90.0 - variant.angle_deg / 2
    return first_deg, variant.resolution_cdeg / 100, variant.mirror_turns


def count_word(count: int, units: int, quarter: int | None = None) -> bytes:
    """Return the word before measured values: their number, the unit, a partial scan's offset."""
    partial = 0 if quarter is None else _PARTIAL | quarter << _QUARTER_SHIFT
    return struct.pack("<H", count | partial | units << 14)


def encode_ranges(
    ranges: NDArray[np.float64],
    mode: MeasuringMode,
    units: int,
    reflectors: NDArray[np.bool_] | None = None,
    inf_means: Special = Special.NO_RETURN,
) -> NDArray[np.uint16]:
    """Return ranges (n,), m, as they are sent, (n,); inf and nan become ``inf_means``.

    reflectors: (n,) beams that ended on one, at the highest level of a mode that reports them.
    """
    missing = mode.limit - Special.BEYOND_MAXIMUM + inf_means
    values = np.full(ranges.shape, missing, dtype="<u2")
    finite = np.isfinite(ranges)
    counts = np.rint(ranges[finite] / _METRES[units])
    values[finite] = np.clip(counts, 0, mode.limit).astype("<u2")
    if reflectors is not None:
        values[reflectors & (values < mode.limit)] |= mode.reflector_bits << _FLAG_SHIFT
    return values

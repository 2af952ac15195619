"""Measured values other than whole scans: means, sub-ranges, ranges with reflectivity.

Source: SICK telegram listing 8007954/Q501, replies B6, B7, BF, F5; their layouts as Player,
sicktoolbox and CARMEN read them.
"""

from __future__ import annotations

import struct
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from drivers.lms200.framing import Telegram
from drivers.lms200.measurement import (
    Measurement,
    MeasuringMode,
    decode_measurement,
    decode_values,
    read_count_word,
)
from drivers.lms200.telegrams import (
    MEASURED_VALUES,
    SELECT_CONTINUOUS,
    SELECT_CONTINUOUS_TURNS,
    Command,
    Mode,
    Variant,
)

_AHEAD_DEG = 90.0
_INDICES = 2  # bytes of scan and telegram index, where enabled


def stream_command(
    *, mean_of: int, part: tuple[int, int] | None, remission: bool, turns: bool, count: int
) -> bytes:
    """Return the command that starts a stream.

    mean_of: scans averaged. part: first and last value, 1-based, None for all ``count``.
    remission: with reflectivity. turns: each mirror turn by itself.
    """
    ends = struct.pack("<HH", *(part or (1, count)))
    if turns:
        return SELECT_CONTINUOUS_TURNS
    if remission:
        return bytes((Command.MODE, Mode.REFLECTIVITY_PARTS, 1, 0)) + ends
    if mean_of > 1 and part is None:
        return bytes((Command.MODE, Mode.MEANS, mean_of))
    if mean_of > 1:
        return bytes((Command.MODE, Mode.MEANS_OF_SUB_RANGE, mean_of)) + ends
    if part is not None:
        return bytes((Command.MODE, Mode.SUB_RANGE)) + ends
    return SELECT_CONTINUOUS


def decode_output(telegram: Telegram, mode: MeasuringMode, variant: Variant) -> Measurement | None:
    """Decode measured values of a laser set to ``variant``; None for what is none of the kinds.

    None too where the length differs from the count, or the sub-range from the variant.
    """
    if telegram.code == MEASURED_VALUES:
        return decode_measurement(telegram, mode)
    decode = _DECODERS.get(telegram.code)
    return None if decode is None else decode(telegram.payload, mode, variant)


def _means(payload: bytes, mode: MeasuringMode, variant: Variant) -> Measurement | None:
    if len(payload) < 2:
        return None
    return _part(payload, 2, (1, variant.count), mode, variant, scans=payload[1])


def _sub_range(payload: bytes, mode: MeasuringMode, variant: Variant) -> Measurement | None:
    if len(payload) < 8:
        return None
    first, last = struct.unpack_from("<HH", payload, 1)
    return _part(payload, 5, (first, last), mode, variant)


def _means_of_sub_range(
    payload: bytes, mode: MeasuringMode, variant: Variant
) -> Measurement | None:
    if len(payload) < 9:
        return None
    first, last = struct.unpack_from("<HH", payload, 2)
    return _part(payload, 6, (first, last), mode, variant, scans=payload[1])


def _with_reflectivity(payload: bytes, mode: MeasuringMode, variant: Variant) -> Measurement | None:
    if len(payload) < 10:
        return None
    parts, first, last = struct.unpack_from("<3H", payload, 1)
    if parts != 1:
        return None
    return _part(payload, 7, (first, last), mode, variant, remission=True)


def _part(
    payload: bytes,
    at: int,
    ends: tuple[int, int],
    mode: MeasuringMode,
    variant: Variant,
    *,
    scans: int = 1,
    remission: bool = False,
) -> Measurement | None:
    """Decode the values behind the count word at ``at``; ends: their numbers in the scan."""
    if len(payload) < at + 3 or not 1 <= ends[0] <= ends[1] <= variant.count or not scans:
        return None
    count, metres = read_count_word(payload, at)
    words = 2 if remission else 1
    length = at + 2 + 2 * words * count + 1
    if metres is None or count != ends[1] - ends[0] + 1:
        return None
    if len(payload) not in (length, length + _INDICES):
        return None
    raw: NDArray[np.uint16] = np.frombuffer(payload, "<u2", words * count, offset=at + 2)
    step_deg = variant.resolution_cdeg / 100
    return Measurement(
        *decode_values(raw[::words], mode, metres),
        first_deg=_AHEAD_DEG - variant.angle_deg / 2 + (ends[0] - 1) * step_deg,
        step_deg=step_deg,
        mirror_turns=variant.mirror_turns,
        status=payload[-1],
        scans=scans,
        remission=raw[1::2] if remission else None,
    )


_DECODERS: dict[int, Callable[[bytes, MeasuringMode, Variant], Measurement | None]] = {
    Command.MEAN_VALUES.reply: _means,
    Command.SUB_RANGE.reply: _sub_range,
    Command.MEAN_SUB_RANGE.reply: _means_of_sub_range,
    Command.REFLECTIVITY_PARTS.reply: _with_reflectivity,
}

OUTPUT_CODES = frozenset((MEASURED_VALUES, *_DECODERS))
"""The codes of telegrams with measured values."""

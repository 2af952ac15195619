"""Telegrams of measured values of an emulated LMS 200, from what its mirror measured.

Source: SICK telegram listing 8007954/Q501, replies B0, B6, B7, BE, BF, C4, F5; their layouts as
Player, sicktoolbox and CARMEN read them. F6 and E9 are ours.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from drivers.lms200.emulator.laser_state import LaserState
from drivers.lms200.emulator.measured_output import Content, MeasuredOutput
from drivers.lms200.emulator.mirror import Sweep
from drivers.lms200.measurement import (
    MEASURING_MODES,
    MeasuringMode,
    count_word,
    encode_ranges,
)
from drivers.lms200.telegrams import ACCEPTED, Command
from drivers.scan import Special

MODE_REFLECTIVITY_ONLY = 0x3F  # reflectivity in place of ranges

_HALF_TURN_DEG = 180.0
_FIELD_BITS = {0x00: (13, 14), 0x02: (13, 14, 15), 0x04: (14, 15), 0x06: (15,)}
"""By measuring mode: the bits of fields A, B, C."""
_MOST_REFLECTIVITY = 13000  # of the 16-bit values; about the listing's largest
_DIFFUSE = 0.15  # share of it that a plain surface returns; ours
_METRES = {0: 0.01, 1: 0.001}
_WITH_ENDS = {
    Command.SUB_RANGE.reply,
    Command.MEAN_SUB_RANGE.reply,
    Command.FIELD_VALUES.reply,
}
"""Replies that begin with the first and last number of the sub-range."""


def mean_of(sweeps: Sequence[Sweep]) -> Sweep:
    """Return the mean of whole sweeps; a beam without a range in one of them has none."""
    last = sweeps[-1]
    if len(sweeps) == 1:
        return last
    total: NDArray[np.float64] = np.sum([sweep.ranges for sweep in sweeps], axis=0)
    return replace(last, ranges=total / len(sweeps))


def degrees_of(sweep: Sweep, state: LaserState) -> NDArray[np.float64]:
    """Return the directions (n,) of a sweep's beams, degrees, 0 right."""
    if sweep.quarter is not None:
        return sweep.quarter / 4 + np.arange(sweep.ranges.size, dtype=np.float64)
    first = (_HALF_TURN_DEG - state.variant.angle_deg) / 2
    step = state.variant.resolution_cdeg / 100
    return first + step * np.arange(sweep.ranges.size, dtype=np.float64)


def encode_output(
    output: MeasuredOutput, sweep: Sweep, state: LaserState, indices: bytes, *, dazzled: bool
) -> bytes:
    """Return the telegram of a sweep, without its status byte.

    indices: scan and telegram index, where enabled. dazzled: whether a missing range means that.
    """
    head = bytes((output.reply,))
    finding = _FINDINGS.get(output.content)
    if finding is not None:
        return head + finding(output, sweep, state)
    values = _values(sweep, state, dazzled=dazzled)
    units = state.configuration.units
    if output.content is Content.PAIRS:
        return head + _pairs(output, values, sweep, units) + indices
    if output.content is Content.WITH_REFLECTIVITY:
        return head + _with_reflectivity(output, values, sweep, units) + indices
    if output.scans > 1:
        head += bytes((output.scans,))
    if output.parts and output.reply in _WITH_ENDS:
        head += struct.pack("<HH", *output.parts[0])
    values = _selected(output, values, sweep, state)
    return head + count_word(values.size, units, sweep.quarter) + values.tobytes() + indices


def _selected(
    output: MeasuredOutput, values: NDArray[np.uint16], sweep: Sweep, state: LaserState
) -> NDArray[np.uint16]:
    """Return the values that are sent of a scan's (n,)."""
    beams_per_degree = state.variant.mirror_turns
    if output.content is Content.SEGMENT_MINIMA:
        return _minima(values, beams_per_degree)
    if output.content is Content.DEPTH_MINIMA:
        sines = np.sin(np.radians(degrees_of(sweep, state)))
        with np.errstate(invalid="ignore"):  # no return, at either end of the baseline
            depths = sweep.ranges * sines
        return _minima(_values(replace(sweep, ranges=depths), state), beams_per_degree)
    if output.content is Content.PART_MINIMA:
        return np.array([values[a - 1 : b].min() for a, b in output.parts], dtype="<u2")
    for first, last in output.parts:
        values = values[first - 1 : last]
    return values[:: output.stride]


def _values(sweep: Sweep, state: LaserState, *, dazzled: bool = False) -> NDArray[np.uint16]:
    """Return a sweep's values (n,) as the measuring mode has them."""
    configuration = state.configuration
    if configuration.measuring_mode == MODE_REFLECTIVITY_ONLY:
        return _reflectivity(sweep)
    mode = MEASURING_MODES[configuration.measuring_mode]
    inf_means = Special.DAZZLED if dazzled else Special.NO_RETURN
    values = encode_ranges(sweep.ranges, mode, configuration.units, sweep.reflectors, inf_means)
    if state.fields.stored:
        _mark_fields(values, sweep, state, mode)
    return values


def _mark_fields(
    values: NDArray[np.uint16], sweep: Sweep, state: LaserState, mode: MeasuringMode
) -> None:
    """Set the bits of the fields that beams end in."""
    configuration = state.configuration
    inside = state.fields.beams_inside(sweep.ranges, degrees_of(sweep, state), configuration.units)
    bits = _FIELD_BITS.get(configuration.measuring_mode, ())
    for bit, beams in zip(bits, inside, strict=False):
        values[beams & (values & mode.mask < mode.limit)] |= 1 << bit


def _minima(values: NDArray[np.uint16], beams: int) -> NDArray[np.uint16]:
    """Return the smallest value of each segment of 1 degree: of ``beams`` beams in a row."""
    minima: NDArray[np.uint16] = np.minimum.reduceat(values, np.arange(0, values.size, beams))
    return minima


def _reflectivity(sweep: Sweep) -> NDArray[np.uint16]:
    """Return what beams return (n,), up to _MOST_REFLECTIVITY; 0 for no return."""
    share = np.where(np.isfinite(sweep.ranges), _DIFFUSE, 0.0)
    if sweep.reflectors is not None:
        share[sweep.reflectors & np.isfinite(sweep.ranges)] = 1.0
    values: NDArray[np.uint16] = np.rint(share * _MOST_REFLECTIVITY).astype("<u2")
    return values


def _pairs(output: MeasuredOutput, values: NDArray[np.uint16], sweep: Sweep, units: int) -> bytes:
    pairs = np.column_stack((values, _reflectivity(sweep))).astype("<u2")
    data = struct.pack("<H", len(output.parts))
    for first, last in output.parts:
        count = count_word(last - first + 1, units, sweep.quarter)
        data += struct.pack("<HH", first, last) + count + pairs[first - 1 : last].tobytes()
    return data


def _with_reflectivity(
    output: MeasuredOutput, values: NDArray[np.uint16], sweep: Sweep, units: int
) -> bytes:
    ((first, last),) = output.parts
    share = _reflectivity(sweep) / _MOST_REFLECTIVITY
    octets: NDArray[np.uint8] = np.rint(share * 0xFF).astype(np.uint8)
    ranges = count_word(values.size, units, sweep.quarter) + values.tobytes()
    part = struct.pack("<HHH", last - first + 1, first, last)
    return ranges + part + octets[first - 1 : last].tobytes()


def _cartesian(output: MeasuredOutput, sweep: Sweep, state: LaserState) -> bytes:
    """Return x right and y ahead of a sub-range's ends, signed words; no return is the largest."""
    ((first, last),) = output.parts
    ranges = sweep.ranges[first - 1 : last]
    angles = np.radians(degrees_of(sweep, state)[first - 1 : last])
    units = state.configuration.units
    with np.errstate(invalid="ignore"):
        points = np.column_stack((ranges * np.cos(angles), ranges * np.sin(angles)))
    words = np.nan_to_num(points / _METRES[units], nan=0x7FFF, posinf=0x7FFF, neginf=0x7FFF)
    clipped = np.clip(np.rint(words), -0x7FFF, 0x7FFF).astype("<i2")
    return struct.pack("<HH", first, last) + count_word(len(words), units) + clipped.tobytes()


def _positions(output: MeasuredOutput, sweep: Sweep, _state: LaserState) -> bytes:
    """Return the number of reflectors in a sub-range, then of each the first and last beam."""
    ((first, last),) = output.parts
    none = np.zeros(sweep.ranges.size, dtype=np.bool_)
    seen = (none if sweep.reflectors is None else sweep.reflectors)[first - 1 : last]
    edges = np.flatnonzero(np.diff(np.concatenate(([False], seen, [False])).astype(np.int8)))
    spans = [(first + a, first + b - 1) for a, b in zip(edges[::2], edges[1::2], strict=True)]
    return bytes((len(spans),)) + b"".join(struct.pack("<HH", *span) for span in spans)


def _field_outputs(_output: MeasuredOutput, _sweep: Sweep, state: LaserState) -> bytes:
    return bytes(state.fields.infringed(state.configuration.evaluations))


def _taught(output: MeasuredOutput, sweep: Sweep, state: LaserState) -> bytes:
    degrees, units = degrees_of(sweep, state), state.configuration.units
    state.fields.teach(output.field, sweep.ranges, degrees, units)
    return bytes((ACCEPTED,))


_FINDINGS: dict[Content, Callable[[MeasuredOutput, Sweep, LaserState], bytes]] = {
    Content.CARTESIAN: _cartesian,
    Content.POSITIONING: _positions,
    Content.FIELD_OUTPUTS: _field_outputs,
    Content.TEACHING: _taught,
}
"""What is sent, behind the reply code, of contents that are no values."""

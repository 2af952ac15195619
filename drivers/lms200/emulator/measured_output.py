"""What measured values an LMS 200 is told to send: by an operating mode, or once on request.

Source: SICK telegram listing 8007954/Q501, operating modes 20h to 2Eh and 50h and the requests with
the same content; where a reply is known by no client, it is ours (``listing.toml`` beside the tests
says which).
"""

from __future__ import annotations

import struct
from dataclasses import dataclass, replace
from enum import Enum, auto

from drivers.lms200.framing import MAX_PAYLOAD
from drivers.lms200.telegrams import MEASURED_VALUES, Command, Mode, Variant

SCANS_AVERAGED = range(2, 251)
MOST_PARTS = 5

_DIRECT = 0x8000  # in a sub-range's first number: send it without waiting for the scan's end


class Content(Enum):
    """What is sent of a scan."""

    RANGES = auto()
    SEGMENT_MINIMA = auto()
    DEPTH_MINIMA = auto()
    PART_MINIMA = auto()
    WITH_REFLECTIVITY = auto()
    PAIRS = auto()
    CARTESIAN = auto()
    FIELD_OUTPUTS = auto()
    TEACHING = auto()
    POSITIONING = auto()


class Parameters(Enum):
    """The parameters of a command, by their order."""

    NONE = auto()
    SCANS = auto()
    PART = auto()
    SCANS_PART = auto()
    PARTS = auto()


@dataclass(frozen=True, slots=True)
class MeasuredOutput:
    """One kind of measured values.

    reply: the code they are sent with. scans: number averaged. parts: first and last value of the
    sub-ranges, 1-based; empty for the whole scan. stride: every so many values. turns: each mirror
    turn by itself. if_infringed: only while a field is. field: the number of one to be taught.
    """

    reply: int = MEASURED_VALUES
    content: Content = Content.RANGES
    scans: int = 1
    parts: tuple[tuple[int, int], ...] = ()
    stride: int = 1
    turns: bool = False
    if_infringed: bool = False
    field: int = 0


_NONE, _SCANS, _PART = Parameters.NONE, Parameters.SCANS, Parameters.PART
_MODES: dict[Mode, tuple[Parameters, MeasuredOutput]] = {
    Mode.SEGMENTS: (_NONE, MeasuredOutput(content=Content.SEGMENT_MINIMA)),
    Mode.SEGMENTS_INFRINGED: (
        _NONE,
        MeasuredOutput(content=Content.SEGMENT_MINIMA, if_infringed=True),
    ),
    Mode.DEPTHS: (_NONE, MeasuredOutput(content=Content.DEPTH_MINIMA)),
    Mode.DEPTHS_INFRINGED: (
        _NONE,
        MeasuredOutput(content=Content.DEPTH_MINIMA, if_infringed=True),
    ),
    Mode.CONTINUOUS: (_NONE, MeasuredOutput()),
    Mode.MEANS: (_SCANS, MeasuredOutput(Command.MEAN_VALUES.reply)),
    Mode.SUB_RANGE: (_PART, MeasuredOutput(Command.SUB_RANGE.reply)),
    Mode.MEANS_OF_SUB_RANGE: (
        Parameters.SCANS_PART,
        MeasuredOutput(Command.MEAN_SUB_RANGE.reply),
    ),
    Mode.FIELD_VALUES: (_PART, MeasuredOutput(Command.FIELD_VALUES.reply)),
    Mode.CONTINUOUS_TURNS: (_NONE, MeasuredOutput(turns=True)),
    Mode.REFLECTIVITY_PARTS: (
        Parameters.PARTS,
        MeasuredOutput(Command.REFLECTIVITY_PARTS.reply, Content.PAIRS),
    ),
    Mode.SUB_RANGE_MINIMA: (Parameters.PARTS, MeasuredOutput(content=Content.PART_MINIMA)),
    Mode.NAVIGATION: (_NONE, MeasuredOutput()),
    Mode.RANGES_AND_REFLECTIVITY: (
        _PART,
        MeasuredOutput(Command.RANGES_AND_REFLECTIVITY.reply, Content.WITH_REFLECTIVITY),
    ),
}
"""By mode: its parameters, and what it sends."""

_COMMANDS: dict[int, tuple[Parameters, MeasuredOutput]] = {
    Command.MEAN_VALUES: _MODES[Mode.MEANS],
    Command.SUB_RANGE: _MODES[Mode.SUB_RANGE],
    Command.FIELD_VALUES: _MODES[Mode.FIELD_VALUES],
    Command.MEAN_SUB_RANGE: _MODES[Mode.MEANS_OF_SUB_RANGE],
    Command.RANGES_AND_REFLECTIVITY: _MODES[Mode.RANGES_AND_REFLECTIVITY],
    Command.REFLECTIVITY_PARTS: _MODES[Mode.REFLECTIVITY_PARTS],
    Command.CARTESIAN: (_PART, MeasuredOutput(Command.CARTESIAN.reply, Content.CARTESIAN)),
}
_SCAN_REQUESTS: dict[int, tuple[Parameters, MeasuredOutput]] = {
    0x01: (_NONE, MeasuredOutput()),
    0x02: _MODES[Mode.SEGMENTS],
    0x03: _MODES[Mode.DEPTHS],
    0x05: _MODES[Mode.MEANS],
    0x06: (_NONE, MeasuredOutput(stride=2)),
    0x07: (_NONE, MeasuredOutput(stride=20)),
    0x08: _MODES[Mode.CONTINUOUS_TURNS],
}
"""By the first data byte of command 30."""


def is_stream(mode: int) -> bool:
    """Return whether an operating mode sends measured values."""
    return mode in _MODES


def streamed(mode: Mode, parameters: bytes, variant: Variant) -> MeasuredOutput | None:
    """Return what an operating mode sends; None where the parameters are not its own."""
    return _with(*_MODES[mode], parameters, variant)


def requested(command: int, data: bytes, variant: Variant) -> MeasuredOutput | None:
    """Return what a command asks for; None for one that asks for no measured values."""
    if command == Command.REQUEST and data:
        kind, parameters = data[0], data[1:]
        if kind == 0x01 and parameters:
            return _with(Parameters.PART, MeasuredOutput(), parameters, variant)
        found = _SCAN_REQUESTS.get(kind)
        return None if found is None else _with(*found, parameters, variant)
    known = _COMMANDS.get(command)
    return None if known is None else _with(*known, data, variant)


def _with(
    syntax: Parameters, output: MeasuredOutput, data: bytes, variant: Variant
) -> MeasuredOutput | None:
    """Return the output with the parameters in ``data``; None if they do not fit the variant."""
    match syntax:
        case Parameters.NONE:
            return None if data else output
        case Parameters.SCANS | Parameters.SCANS_PART:
            if not data or data[0] not in SCANS_AVERAGED:
                return None
            averaged = replace(output, scans=data[0])
            if syntax is Parameters.SCANS:
                return None if data[1:] else averaged
            return _with_parts(averaged, data[1:], 1, variant)
        case Parameters.PART:
            return _with_parts(output, data, 1, variant)
        case Parameters.PARTS:
            parts = int.from_bytes(data[:2], "little")
            return _with_parts(output, data[2:], parts, variant)


def _with_parts(
    output: MeasuredOutput, data: bytes, count: int, variant: Variant
) -> MeasuredOutput | None:
    if not 1 <= count <= MOST_PARTS or len(data) != 4 * count:
        return None
    words = struct.unpack(f"<{2 * count}H", data)
    parts = tuple(
        (first & ~_DIRECT, last) for first, last in zip(words[::2], words[1::2], strict=True)
    )
    if not all(1 <= first <= last <= variant.count for first, last in parts):
        return None
    output = replace(output, parts=parts)
    return output if _length(output, variant) <= MAX_PAYLOAD else None


def _length(output: MeasuredOutput, variant: Variant) -> int:
    """Return the most bytes of its telegram's content."""
    values = sum(last - first + 1 for first, last in output.parts)
    ends = 1 + 2 + 1  # reply code, indices, status
    match output.content:
        case Content.PAIRS:
            return ends + 2 + 6 * len(output.parts) + 4 * values
        case Content.CARTESIAN:
            return ends + 6 + 4 * values
        case Content.WITH_REFLECTIVITY:
            return ends + 2 + 2 * variant.count + 6 + values
    return ends + 7 + 2 * values

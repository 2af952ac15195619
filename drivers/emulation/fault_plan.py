"""The faults of a line and their times, and the command-line syntax for them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace


class FaultSpecError(ValueError):
    """A fault specification that cannot be used; the message names the part and a remedy."""


@dataclass(frozen=True, slots=True)
class Span:
    """The time from ``begin`` up to, not including, ``end``, s since the line was first used."""

    begin: float
    end: float

    def __contains__(self, t: float) -> bool:
        return self.begin <= t < self.end


@dataclass(frozen=True, slots=True)
class FaultPlan:
    """The faults of a line, applied in both directions.

    drop, corrupt: probability per byte of being lost, of having one bit flipped.
    duplicate, split, delay: probability per write of arriving twice, in two parts, ``delay_time``
    (s) late; order is kept.
    silences: nothing passes. cuts: the same, and the port goes away. resets: times, s, at which
    the device restarts.
    """

    drop: float = 0.0
    corrupt: float = 0.0
    duplicate: float = 0.0
    split: float = 0.0
    delay: float = 0.0
    delay_time: float = 0.0
    silences: tuple[Span, ...] = ()
    cuts: tuple[Span, ...] = ()
    resets: tuple[float, ...] = ()


_EXAMPLE = (
    "use e.g. drop=0.01,corrupt=0.001,duplicate=0.01,split=0.1,delay=0.05:0.2,"
    "silence=5:8,cut=12:15,reset=20"
)


def parse_faults(spec: str) -> FaultPlan:
    """Parse faults from ``name=value,name=value``.

    Probabilities are 0 to 1, times s; ``delay=P:S``, ``silence=FROM:TO``, ``cut=FROM:TO`` and
    ``reset=AT``, the last three as often as wanted. Raises FaultSpecError.
    """
    plan = FaultPlan()
    for part in filter(None, (piece.strip() for piece in spec.split(","))):
        name, given, text = part.partition("=")
        if not given:
            raise FaultSpecError(f"fault '{part}': has no value; {_EXAMPLE}")
        plan = _with(plan, name.strip(), _numbers(part, text), part)
    return plan


def _with(plan: FaultPlan, name: str, numbers: Sequence[float], part: str) -> FaultPlan:
    match name, len(numbers):
        case "drop", 1:
            return replace(plan, drop=_probability(numbers[0], part))
        case "corrupt", 1:
            return replace(plan, corrupt=_probability(numbers[0], part))
        case "duplicate", 1:
            return replace(plan, duplicate=_probability(numbers[0], part))
        case "split", 1:
            return replace(plan, split=_probability(numbers[0], part))
        case "delay", 2:
            return replace(plan, delay=_probability(numbers[0], part), delay_time=numbers[1])
        case "silence", 2:
            return replace(plan, silences=(*plan.silences, _span(numbers, part)))
        case "cut", 2:
            return replace(plan, cuts=(*plan.cuts, _span(numbers, part)))
        case "reset", 1:
            return replace(plan, resets=tuple(sorted((*plan.resets, *numbers))))
    raise FaultSpecError(f"fault '{part}': no such fault, or not its values; {_EXAMPLE}")


def _numbers(part: str, text: str) -> list[float]:
    found = [value.strip() for value in text.split(":")]
    if not all(re.fullmatch(r"\d+\.?\d*|\.\d+", value) for value in found):
        raise FaultSpecError(f"fault '{part}': values are numbers, not negative; {_EXAMPLE}")
    return [float(value) for value in found]


def _probability(value: float, part: str) -> float:
    if value > 1.0:
        raise FaultSpecError(f"fault '{part}': a probability is 0 to 1; {_EXAMPLE}")
    return value


def _span(span: Sequence[float], part: str) -> Span:
    begin, end = span
    if begin >= end:
        raise FaultSpecError(f"fault '{part}': ends before it begins; {_EXAMPLE}")
    return Span(begin, end)

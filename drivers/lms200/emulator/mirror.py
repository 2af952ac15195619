"""The rotating mirror of an emulated LMS 200: which beams are measured when.

Source: SICK telegram listing 8007954/Q501, resolution and mirror, partial scans.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from drivers.lms200.telegrams import Variant

TURN = 13.32e-3
"""s, one turn of this device's mirror (75 a second); the driver has a value of its own."""
PARTIAL_ANGLE_DEG = 180
"""Field of view of a partial scan, whatever that of the variant."""
ScanSource = Callable[[float, int, float], NDArray[np.float64]]
"""(t, n, increment) -> ranges (n,) m at time t, rightmost beam first, inf for no return."""
ReflectorSource = Callable[[], NDArray[np.bool_] | None]
"""() -> (n,) beams of the latest turn measured that ended on a reflector, None for none."""


@dataclass(frozen=True, slots=True, eq=False)
class Sweep:
    """The content of one telegram: ranges (n,) m; ``end`` is when its last mirror turn ends (s).

    ``quarter`` is a partial scan's offset in quarters of a degree, None of a whole one.
    ``reflectors`` (n,) are the beams that ended on a reflector, None for none.
    """

    ranges: NDArray[np.float64]
    end: float
    quarter: int | None
    reflectors: NDArray[np.bool_] | None = None

    @property
    def turn(self) -> int:
        """Number of its last mirror turn since time 0."""
        return round(self.end / TURN)


class Turn(NamedTuple):
    """A mirror turn that is used: its middle and the end of its sweep (s), the scan's number of
    beams and the angle between them (rad)."""

    middle: float
    beams: int
    increment: float
    sweep_end: float


class EmulatedMirror:
    """A mirror that turns from time 0 on; each turn measures in steps of 1 degree.

    A whole scan takes as many turns as the variant interlaces, each measured at its own time.
    ``start`` sets the earliest beginning of a sweep; ``measure`` then returns one after another.
    """

    def __init__(self, source: ScanSource, reflectors: ReflectorSource | None = None) -> None:
        self._source = source
        self._reflectors = reflectors
        self._begin: float | None = None
        self._partial = False
        self._phase = 0  # of the next partial scan
        self._under_way: float | None = None  # end of the sweep that ``_fans`` belong to
        self._fans: list[NDArray[np.float64]] = []
        self._reflected: list[NDArray[np.bool_]] = []  # of those fans, if any
        self._idle_until = -math.inf
        """No turn is due before this time: a busy wire can only delay it."""

    def start(self, t: float, *, partial: bool = False) -> None:
        """Measure whole sweeps that begin at ``t`` or later, or with ``partial`` single turns."""
        self._begin = t
        self._partial = partial
        self._phase = 0
        self._under_way = None
        self._idle_until = -math.inf

    def stop(self) -> None:
        """Stop measuring."""
        self._begin = None

    def measure(self, variant: Variant, wire_free: float, t: float) -> Sweep | None:
        """Measure the turns due by ``t``; return the sweep they complete, None if there is none.

        A sweep that would end before the wire is free is not measured.
        """
        while (turn := self.due(variant, wire_free, t)) is not None:
            if turn.sweep_end != self._under_way:  # none in progress, or the wire was busy
                self._under_way, self._fans, self._reflected = turn.sweep_end, [], []
            self._fans.append(self._source(turn.middle, turn.beams, turn.increment))
            if self._reflectors is not None and (reflected := self._reflectors()) is not None:
                self._reflected.append(reflected)
            if len(self._fans) == self._turns(variant):
                return self._finish(variant, turn.sweep_end)
        return None

    def due(self, variant: Variant, wire_free: float, t: float) -> Turn | None:
        """Return the next turn to be measured; None if its middle is after ``t``."""
        if t < self._idle_until:
            return None
        end = self._next_end(variant, wire_free)
        if end is None:
            return None
        done = len(self._fans) if end == self._under_way else 0
        middle = end - (self._turns(variant) - done - 0.5) * TURN
        if middle > t:
            self._idle_until = middle
            return None
        resolution_cdeg = variant.resolution_cdeg
        beams = (
            variant.count if not self._partial else PARTIAL_ANGLE_DEG * 100 // resolution_cdeg + 1
        )
        return Turn(middle, beams, math.radians(resolution_cdeg / 100), end)

    def _turns(self, variant: Variant) -> int:
        return 1 if self._partial else variant.mirror_turns

    def _next_end(self, variant: Variant, wire_free: float) -> float | None:
        """Return the end of the next sweep, s; None if not measuring."""
        if self._begin is None:
            return None
        whole = variant.mirror_turns * TURN
        if not self._partial:
            first = next_multiple(self._begin, whole) + whole
            return max(first, next_multiple(wire_free, whole))
        first_end = (self._phase + 1) * TURN  # of this phase since time 0
        earliest = max(self._begin + TURN, wire_free)
        return first_end + next_multiple(earliest - first_end, whole)

    def _finish(self, variant: Variant, end: float) -> Sweep:
        self._begin = end
        if self._partial:
            phase, step = self._phase, variant.mirror_turns
            self._phase = (phase + 1) % step
            reflected = self._reflected[0][phase::step] if self._reflected else None
            quarter = phase * variant.resolution_cdeg // 25
            return Sweep(self._fans[0][phase::step], end, quarter, reflected)
        reflected = _interlaced(self._reflected) if self._reflected else None
        return Sweep(_interlaced(self._fans), end, None, reflected)


_Value = TypeVar("_Value", np.float64, np.bool_)


def _interlaced(fans: Sequence[NDArray[_Value]]) -> NDArray[_Value]:
    """Return the values (n,) of a scan, each beam's of the fan of its turn, (n,) each."""
    values = fans[0].copy()
    for phase, fan in enumerate(fans):
        values[phase :: len(fans)] = fan[phase :: len(fans)]
    return values


@lru_cache(maxsize=8)
def beam_delays(n: int, increment: float) -> NDArray[np.float64]:
    """Return (n,) s, read-only, from the middle of a turn's sweep until each beam is measured.

    increment: rad between beams. The mirror turns once in TURN, counter-clockwise, and looks along
    the laser's axis in the middle.
    """
    beams = np.arange(n, dtype=np.float64) - (n - 1) / 2
    delays: NDArray[np.float64] = beams * (increment / math.tau * TURN)
    delays.setflags(write=False)
    return delays


def next_multiple(t: float, period: float) -> float:
    """Return the first multiple of ``period`` at or after ``t``, within rounding."""
    return math.ceil(t / period - 1e-6) * period

"""The rotating mirror of an emulated LMS 1xx: one scan each turn, 270 degrees of it.

Source: SICK's data sheet of the LMS 111: 270 degrees, 25 and 50 Hz, 0.25 and 0.5 degrees.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

SECTOR_DEG = 270.0
ScanSource = Callable[[float, int, float], NDArray[np.float64]]
"""(t, n, increment) -> ranges (n,) m at time t, rightmost beam first, inf for no return."""


class Turn(NamedTuple):
    """A mirror turn that is used: its middle (s), the scan's number of beams and the angle between
    them (rad), and the end of its sweep (s)."""

    middle: float
    beams: int
    increment: float
    sweep_end: float


class EmulatedMirror:
    """A mirror that turns from ``start`` on, and passes straight ahead in the middle of a turn."""

    def __init__(self, frequency: float, resolution_deg: float) -> None:
        """Set up; frequency: turns a second."""
        self.frequency = frequency
        self.resolution_deg = resolution_deg
        self._start: float | None = None
        self._turn = 0

    @property
    def turn_time(self) -> float:
        """Time of one turn, s."""
        return 1.0 / self.frequency

    def start(self, t: float) -> None:
        """Begin a turn at ``t``."""
        self._start, self._turn = t, 0

    def stop(self) -> None:
        """Stop turning."""
        self._start = None

    @property
    def number(self) -> int:
        """Number of the next turn to be taken."""
        return self._turn

    def next_turn(self) -> Turn | None:
        """Return the next turn to be taken; None of a mirror that stands."""
        if self._start is None:
            return None
        middle = self._start + (self._turn + 0.5) * self.turn_time
        beams = round(SECTOR_DEG / self.resolution_deg) + 1
        end = middle + 0.5 * SECTOR_DEG / 360.0 * self.turn_time
        return Turn(middle, beams, math.radians(self.resolution_deg), end)

    def take(self) -> None:
        """Go on to the turn after the next one."""
        self._turn += 1

    def skip_to(self, t: float) -> None:
        """Take all turns whose middle is before ``t``: nobody looked at them."""
        if self._start is not None:
            passed = math.ceil((t - self._start) / self.turn_time - 0.5 - 1e-9)
            self._turn = max(self._turn, passed)


@lru_cache(maxsize=8)
def beam_delays(n: int, increment: float, turn_time: float) -> NDArray[np.float64]:
    """Return (n,) s, read-only, from the middle of a turn's sweep until each beam is measured.

    increment: rad between beams. The mirror turns once in ``turn_time`` (s), counter-clockwise.
    """
    beams = np.arange(n, dtype=np.float64) - (n - 1) / 2
    delays: NDArray[np.float64] = beams * (increment / math.tau * turn_time)
    delays.setflags(write=False)
    return delays

"""One scan of a laser scanner of any kind in SI units, with the time of its measurement."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray


class Special(IntEnum):
    """Why a beam has no range. The numbers are those of the LMS 200, up to NO_RETURN."""

    RANGE = 0  # not special
    BEYOND_MAXIMUM = 1
    READ_ERROR = 4  # of channel 1
    LOW_SIGNAL = 5  # against the noise
    OVERFLOW = 7  # of the laser's calculation
    DAZZLED = 8
    NO_RETURN = 9
    IGNORED = 255  # never sent: in a sector of laser.ignore


@dataclass(frozen=True, slots=True, eq=False)
class Scan:
    """One sweep of the laser, or several interlaced ones; arrays are by beam, (n,).

    t: time of measurement, the middle of the sweep; of an interlaced scan the mean over its turns.
    angle_min, angle_increment: rad in the laser frame (x forward, y left); the first beam is the
    rightmost, beams follow counter-clockwise.
    ranges: float64 m; inf where there is no usable return, never nan.
    status: the telegram's status byte, as the scanner's kind defines it.
    turns: mirror turns; beams i, i + turns, i + 2 turns... come from the same one.
    turn_time: s, of one mirror turn.
    specials: uint8, why a beam has no range, as ``Special``; 0 where it has one.
    flags: uint8, bits 0 to 2 as the measuring mode defines them (fields, dazzle, reflector level).
    reflectors: bool, beams that hit a reflector; None where the scanner does not report it.
    clockwise: whether the beams were measured in the reverse order, by a scanner upside down.
    remission: uint16, what each beam's end reflected, as the scanner scales it; None if not sent.
    """

    t: float
    angle_min: float
    angle_increment: float
    ranges: NDArray[np.float64]
    status: int
    turns: int
    turn_time: float
    specials: NDArray[np.uint8]
    flags: NDArray[np.uint8]
    reflectors: NDArray[np.bool_] | None
    clockwise: bool = False
    remission: NDArray[np.uint16] | None = None

    @property
    def angles(self) -> NDArray[np.float64]:
        """Beam directions (n,) in rad, laser frame."""
        beams = np.arange(self.ranges.size, dtype=np.float64)
        return self.angle_min + self.angle_increment * beams


@lru_cache(maxsize=8)
def beam_time_offsets(
    count: int,
    angle_min: float,
    angle_increment: float,
    turns: int,
    turn_time: float,
    clockwise: bool = False,
) -> NDArray[np.float64]:
    """Return each beam's time relative to the scan's, (count,) s, read-only.

    The mirror passes straight ahead in the middle of its turn and sweeps counter-clockwise at a
    constant rate; beam i belongs to turn i modulo ``turns``. clockwise: as in ``Scan``.
    """
    if clockwise:
        own_first = -(angle_min + angle_increment * (count - 1))
        return beam_time_offsets(count, own_first, angle_increment, turns, turn_time)[::-1]
    beams = np.arange(count)
    turn = beams % turns - (turns - 1) / 2
    place = (angle_min + angle_increment * beams) / math.tau
    offsets: NDArray[np.float64] = (turn + place) * turn_time
    offsets.setflags(write=False)
    return offsets

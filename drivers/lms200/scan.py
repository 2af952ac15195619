"""One laser scan in SI units, dated to the moment it was measured."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivers.lms200.measurement import TURN, Measurement


@dataclass(frozen=True, slots=True, eq=False)
class Scan:
    """One sweep of the laser.

    t: time measured (s), the middle of the sweep; of an interlaced scan the mean over its turns.
    angle_min, angle_increment: rad in the laser frame (x forward, y left); the first beam is the
    rightmost, beams follow counter-clockwise.
    ranges: (n,) float64 m; inf where there is no usable return, never nan.
    status: the telegram's status byte; 0x10 is healthy.
    """

    t: float
    angle_min: float
    angle_increment: float
    ranges: NDArray[np.float64]
    status: int

    @property
    def angles(self) -> NDArray[np.float64]:
        """Beam directions (n,) in rad, laser frame."""
        beams = np.arange(self.ranges.size, dtype=np.float64)
        return self.angle_min + self.angle_increment * beams

    @property
    def delays(self) -> NDArray[np.float64]:
        """When each beam was measured, (n,) s after ``t``; see ``beam_delays``."""
        return beam_delays(self.ranges.size, self.angle_min, self.angle_increment)


def beam_delays(n: int, angle_min: float, increment: float) -> NDArray[np.float64]:
    """Return (n,) s from the middle of a scan to the moment each beam was measured.

    The mirror turns counter-clockwise, once in ``TURN``. It measures every degree; a finer scan
    is interlaced: its beams belong in order to as many successive turns as there are to a degree.
    """
    beams = np.arange(n)
    turns = max(1, round(math.radians(1.0) / increment))
    within = (angle_min + increment * beams) / math.tau
    turn = beams % turns - (turns - 1) / 2
    return np.asarray((within + turn) * TURN, dtype=np.float64)


def scan_of(measurement: Measurement, arrival: float, wire_time: float) -> Scan:
    """Date a measurement whose telegram's last byte arrived at ``arrival`` (s).

    Sending took ``wire_time`` (s) and began when the last mirror turn ended; the middle of the
    sweep lies half of all its turns before that.
    """
    return Scan(
        t=arrival - wire_time - measurement.mirror_turns * TURN / 2,
        angle_min=math.radians(measurement.first_deg - 90.0),
        angle_increment=math.radians(measurement.step_deg),
        ranges=measurement.ranges,
        status=measurement.status,
    )

"""The scan of one telegram of measured values."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from drivers.lms1xx import measurement as values
from drivers.lms1xx.measurement import Channel, Measurement
from drivers.lms1xx.telegrams import PER_DEGREE, PER_HERTZ
from drivers.scan import Scan, Special

FARTHEST = 80.0  # m, of an LMS 5xx; what a larger count says is no range
_AHEAD_DEG = 90.0  # the scanner's own degrees straight ahead
_MILLIMETRE = 0.001  # m
_LONGEST_DELAY = 2  # turns from the scan's mark to the sending; more is no delay
_CLOCK = 1 << 32  # microseconds, at which the scanner's clock starts again


def scan_of(measurement: Measurement, arrival: float) -> Scan | None:
    """Return the scan of a telegram whose last byte arrived at ``arrival`` (s).

    None without ranges of the first echo, or with a geometry no scanner has.
    """
    channel = measurement.channel("DIST1")
    if channel is None or measurement.frequency <= 0:
        return None
    sweep_deg = channel.step * (channel.counts.size - 1) / PER_DEGREE
    usable_scale = math.isfinite(channel.scale) and math.isfinite(channel.offset)
    if not 0.0 < sweep_deg <= 360.0 or not usable_scale:
        return None
    ranges, specials = _ranges(channel)
    turn_time = PER_HERTZ / measurement.frequency
    first_deg = channel.first / PER_DEGREE - _AHEAD_DEG
    return Scan(
        t=arrival - _age(measurement, turn_time, sweep_deg / 360.0 * turn_time),
        angle_min=math.radians(first_deg),
        angle_increment=math.radians(channel.step / PER_DEGREE),
        ranges=ranges,
        status=measurement.status,
        turns=1,
        turn_time=turn_time,
        specials=specials,
        flags=np.zeros(ranges.size, dtype=np.uint8),
        reflectors=None,
    )


def _ranges(channel: Channel) -> tuple[NDArray[np.float64], NDArray[np.uint8]]:
    """Return ranges, m, inf where there is none, and why: (n,) each."""
    counts = channel.counts
    ranges = counts.astype(np.float64)
    ranges *= channel.scale * _MILLIMETRE
    ranges += channel.offset * _MILLIMETRE
    specials = np.zeros(counts.size, dtype=np.uint8)
    far = ~((ranges > 0.0) & (ranges <= FARTHEST))
    specials[far] = Special.BEYOND_MAXIMUM
    small = counts < values.SMALLEST_RANGE
    if small.any():
        specials[small] = Special.READ_ERROR
        specials[counts == values.NO_RETURN] = Special.NO_RETURN
        specials[counts == values.DAZZLED] = Special.DAZZLED
    ranges[specials != Special.RANGE] = np.inf
    return ranges, specials


def _age(measurement: Measurement, turn_time: float, sweep_time: float) -> float:
    """Return how long ago, s, the middle of the sweep was when its telegram arrived.

    The scanner says when it sent the data and when the scan had its mark. By the listing the mark
    is the mirror's zero index, half a turn before the middle; so it is with an LMS 511. An LMS 111
    and a TiM781S send 3 and 8 ms after their marks, less than their sweeps take: there it is the
    end of the sweep.
    """
    delay = (measurement.sent - measurement.counted) % _CLOCK * 1e-6
    if delay > _LONGEST_DELAY * turn_time:
        delay = 0.0
    if delay < sweep_time:
        return delay + 0.5 * sweep_time
    return delay - 0.5 * turn_time

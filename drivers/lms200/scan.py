"""The scan of one telegram of measured values of the LMS 200."""

from __future__ import annotations

import math

from drivers.lms200.measurement import TURN, Measurement
from drivers.scan import Scan


def scan_of(measurement: Measurement, arrival: float, wire_time: float) -> Scan:
    """Return the scan of a measurement whose telegram's last byte arrived at ``arrival`` (s).

    Sending took ``wire_time`` (s) and began when the last mirror turn ended; the middle of the
    sweep lies half of all its turns before that, those of all scans averaged.
    """
    return Scan(
        t=arrival - wire_time - measurement.scans * measurement.mirror_turns * TURN / 2,
        angle_min=math.radians(measurement.first_deg - 90.0),
        angle_increment=math.radians(measurement.step_deg),
        ranges=measurement.ranges,
        status=measurement.status,
        turns=measurement.mirror_turns,
        turn_time=TURN,
        specials=measurement.specials,
        flags=measurement.flags,
        reflectors=measurement.reflectors,
        remission=measurement.remission,
    )

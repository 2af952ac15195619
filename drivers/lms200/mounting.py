"""A scan as the robot takes it: turned over where the scanner is, without the ignored sectors."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from drivers.lms200.measurement import Special
from drivers.lms200.scan import Scan
from drivers.lms200.settings import LaserSettings

_ROUNDING = 1e-9  # rad; a sector's ends belong to it


def as_mounted(scan: Scan, settings: LaserSettings) -> Scan:
    """Return a scan in the laser frame, in which left is left also for a scanner upside down.

    Beams in a sector of ``laser.ignore`` have no range.
    """
    if settings.upside_down:
        scan = _turned_over(scan)
    if not settings.ignored:
        return scan
    angles = scan.angles
    ignored = np.zeros(angles.shape, dtype=np.bool_)
    for first, last in settings.ignored:
        ignored |= (angles >= first - _ROUNDING) & (angles <= last + _ROUNDING)
    return without(scan, ignored, Special.IGNORED)


def without(scan: Scan, beams: NDArray[np.bool_], why: Special) -> Scan:
    """Return a scan in which some beams (n,) have no range."""
    return replace(
        scan,
        ranges=np.where(beams, np.inf, scan.ranges),
        specials=np.where(beams, np.uint8(why), scan.specials),
    )


def _turned_over(scan: Scan) -> Scan:
    return replace(
        scan,
        angle_min=-(scan.angle_min + scan.angle_increment * (scan.ranges.size - 1)),
        ranges=scan.ranges[::-1],
        specials=scan.specials[::-1],
        flags=scan.flags[::-1],
        reflectors=None if scan.reflectors is None else scan.reflectors[::-1],
        clockwise=not scan.clockwise,
    )

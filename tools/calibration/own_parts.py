"""Finds the sectors in which a laser sees its own robot: near returns that never change."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

_FARTHEST = 0.8  # m; own parts are nearer to the laser
_SPREAD = 0.04  # m between the 10th and the 90th percentile of what never changes
_OFTEN = 0.7  # share of scans in which a part returns
_MARGIN_DEG = 1.0  # to each side
_JOINED_DEG = 4.0  # sectors nearer to each other are one
_AHEAD_DEG = 90.0


def own_sectors(
    angles: NDArray[np.float64], ranges: NDArray[np.float64]
) -> list[tuple[float, float]]:
    """Return sectors [from, to], degrees of the scanner: 0 right, 90 ahead, 180 left.

    angles: (b,) rad, laser frame, of an upright scanner. ranges: (scans, b) m, of a drive.
    """
    if not ranges.size:
        return []
    often = np.isfinite(ranges).mean(axis=0) > _OFTEN
    near = np.where(np.isfinite(ranges), ranges, np.nan)
    ends = [math.degrees(float(angle)) + _AHEAD_DEG for angle in (angles[0], angles[-1])]
    sectors: list[tuple[float, float]] = []
    for beam in np.flatnonzero(often):
        low, middle, high = np.nanpercentile(near[:, beam], (10.0, 50.0, 90.0))
        if middle < _FARTHEST and high - low < _SPREAD:
            at = math.degrees(float(angles[beam])) + _AHEAD_DEG
            first, last = max(at - _MARGIN_DEG, ends[0]), min(at + _MARGIN_DEG, ends[1])
            if sectors and first - sectors[-1][1] < _JOINED_DEG:
                first = sectors.pop()[0]
            sectors.append((round(first, 1), round(last, 1)))
    return sectors

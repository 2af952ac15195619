"""Laser ranges to points in ``base_link``."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from drivers.lms200.scan import Scan
from maps.pose import Pose


class ScanProjector:
    """Turns scans into points; keeps the beams' directions, which do not change."""

    def __init__(self, base_from_laser: Pose) -> None:
        self._mount = base_from_laser
        self._geometry: tuple[int, float, float] | None = None
        self._directions = np.empty((0, 2))

    def points(self, scan: Scan) -> NDArray[np.float64]:
        """Return the returns of a scan, shape (n, 2), m, base_link, ordered by bearing.

        Beams without a usable return are left out.
        """
        geometry = (scan.ranges.size, scan.angle_min, scan.angle_increment)
        if geometry != self._geometry:
            self._geometry = geometry
            self._directions = self._beam_directions(*geometry)
        hit = np.isfinite(scan.ranges)
        points = self._directions[hit] * scan.ranges[hit, None]
        points += (self._mount.x, self._mount.y)
        return points

    def _beam_directions(self, n: int, angle_min: float, increment: float) -> NDArray[np.float64]:
        angles = self._mount.theta + angle_min + increment * np.arange(n)
        return np.column_stack((np.cos(angles), np.sin(angles)))


def move_points(points: NDArray[np.float64], transform: Pose) -> NDArray[np.float64]:
    """Apply ``a_from_b`` to points (n, 2) in frame b; returns (n, 2) in frame a."""
    c, s = math.cos(transform.theta), math.sin(transform.theta)
    rotation = np.array(((c, s), (-s, c)))
    moved: NDArray[np.float64] = points @ rotation + (transform.x, transform.y)
    return moved

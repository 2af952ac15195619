"""Laser ranges to points in ``base_link``."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from drivers.lms200.scan import Scan, beam_time_offsets
from maps.pose import Pose
from robot_agent.motion.field_of_view import FieldOfView


class ScanProjector:
    """Projects scans to points in base_link; caches the beams' directions."""

    def __init__(self, base_from_laser: Pose) -> None:
        self._mount = base_from_laser
        self._geometry: tuple[int, float, float, int] | None = None
        self._directions = np.empty((0, 2))
        self._delays = np.empty(0)

    def points(self, scan: Scan, v: float = 0.0, w: float = 0.0) -> NDArray[np.float64]:
        """Return the returns of a scan, shape (n, 2), m, base_link at the middle of the sweep.

        Ordered by bearing; beams without a usable return are left out. v, m/s, and w, rad/s: the
        base's speeds during the sweep, by which the points are deskewed.
        """
        geometry = (scan.ranges.size, scan.angle_min, scan.angle_increment, scan.turns)
        if geometry != self._geometry:
            self._geometry = geometry
            self._directions = self._beam_directions(*geometry[:3])
            self._delays = beam_time_offsets(*geometry)
        hit = hits(scan)
        points = self._directions[hit] * scan.ranges[hit, None]
        points += (self._mount.x, self._mount.y)
        return deskewed(points, self._delays[hit], v, w) if v or w else points

    @property
    def view(self) -> FieldOfView | None:
        """Field of view of the latest scan in base_link; None before the first."""
        if self._geometry is None:
            return None
        n, angle_min, increment, _ = self._geometry
        half = 0.5 * (n - 1) * increment
        mount = self._mount
        return FieldOfView(mount.x, mount.y, mount.theta + angle_min + half, half, math.inf)

    def in_view(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return (n,) which points (n, 2), m, base_link, are in the latest scan's field of view."""
        view = self.view
        return np.zeros(len(points), dtype=np.bool_) if view is None else view.mask(points)

    def _beam_directions(self, n: int, angle_min: float, increment: float) -> NDArray[np.float64]:
        angles = self._mount.theta + angle_min + increment * np.arange(n)
        return np.column_stack((np.cos(angles), np.sin(angles)))


def hits(scan: Scan) -> NDArray[np.bool_]:
    """Return (n,) which beams of a scan have a usable return."""
    return np.isfinite(scan.ranges)


def deskewed(
    points: NDArray[np.float64], delays: NDArray[np.float64], v: float, w: float
) -> NDArray[np.float64]:
    """Return points (n, 2), m, transformed to base_link at one time.

    Each was measured in base_link a delay (n,), s, later. v, m/s, and w, rad/s: the base's speeds
    meanwhile; it moves on an arc.
    """
    turned = w * delays
    c, s = np.cos(turned), np.sin(turned)
    half = 0.5 * turned
    x = points[:, 0] * c - points[:, 1] * s + v * delays * np.cos(half)
    y = points[:, 0] * s + points[:, 1] * c + v * delays * np.sin(half)
    return np.column_stack((x, y))


def move_points(points: NDArray[np.float64], transform: Pose) -> NDArray[np.float64]:
    """Apply ``a_from_b`` to points (n, 2) in frame b; returns (n, 2) in frame a."""
    c, s = math.cos(transform.theta), math.sin(transform.theta)
    rotation = np.array(((c, s), (-s, c)))
    moved: NDArray[np.float64] = points @ rotation + (transform.x, transform.y)
    return moved

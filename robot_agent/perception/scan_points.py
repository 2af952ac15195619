"""Laser ranges to points in ``base_link``."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from drivers.mounting import without
from drivers.scan import Scan, Special, beam_time_offsets
from maps.pose import Pose
from robot_agent.motion.field_of_view import FieldOfView, views_without
from robot_agent.motion.footprint import Footprint

_BODY_INSET = 0.03
"""m inside the outline of the body up to which a return may be of something that touches it: noise
and offset of the laser's ranges. Ours."""


class ScanProjector:
    """Projects scans to points in base_link; caches the beams' directions."""

    def __init__(
        self,
        base_from_laser: Pose,
        ignored: Sequence[tuple[float, float]] = (),
        footprint: Footprint | None = None,
    ) -> None:
        """Prepare for one mounting.

        ignored: first and last direction, rad, laser frame, of sectors not looked into. footprint:
        of the robot, for ``without_body``; None: it has none.
        """
        self._mount = base_from_laser
        self._ignored = ignored
        self._hidden: tuple[tuple[float, float], ...] = ()
        self._footprint = footprint
        reach = 0.0 if footprint is None else footprint.corner_reach
        self._body_reach = reach + math.hypot(base_from_laser.x, base_from_laser.y)
        self.views: tuple[FieldOfView, ...] = ()
        """Fields of view of the latest scan in base_link; none before the first."""
        self._geometry: tuple[int, float, float, int, float, bool] | None = None
        self._directions = np.empty((0, 2))
        self._delays = np.empty(0)
        self._hit = np.empty(0, dtype=np.bool_)  # of the latest scan's beams
        self._ranges = np.empty(0)  # m, likewise; of use where hit

    def points(self, scan: Scan, v: float = 0.0, w: float = 0.0) -> NDArray[np.float64]:
        """Return the returns of a scan, shape (n, 2), m, base_link at the middle of the sweep.

        Ordered by bearing; beams without a usable return are left out. v, m/s, and w, rad/s: the
        base's speeds during the sweep, by which the points are deskewed.
        """
        self._look_along(scan)
        hit = self._hit = hits(scan)
        self._ranges = scan.ranges
        points = self._directions[hit] * scan.ranges[hit, None]
        points += (self._mount.x, self._mount.y)
        return deskewed(points, self._delays[hit], v, w) if v or w else points

    def without_body(self, scan: Scan) -> Scan:
        """Return a scan without the returns from inside the robot's own footprint."""
        near = scan.ranges < self._body_reach
        if self._footprint is None or not near.any():
            return scan
        self._look_along(scan)
        points = self._directions[near] * scan.ranges[near, None]
        points += (self._mount.x, self._mount.y)
        own = near
        own[near] = self._footprint.covers(points, -_BODY_INSET)
        return without(scan, own, Special.IGNORED) if own.any() else scan

    def stand_out(self, places: NDArray[np.float64]) -> bool:
        """Return whether any of (n, 2) places, m, laser frame, is outside the robot's footprint."""
        points = move_points(places, self._mount)
        return self._footprint is None or not self._footprint.covers(points, -_BODY_INSET).all()

    def hide(self, sectors: Sequence[tuple[float, float]]) -> None:
        """Take sectors, rad, laser frame, out of the field of view: something covers them."""
        self._hidden = tuple(sectors)
        self._geometry = None

    def _look_along(self, scan: Scan) -> None:
        """Compute directions, delays and fields of view if the scan's geometry is a new one."""
        n, angle_min, increment = scan.ranges.size, scan.angle_min, scan.angle_increment
        geometry = (n, angle_min, increment, scan.turns, scan.turn_time, scan.clockwise)
        if geometry == self._geometry:
            return
        self._geometry = geometry
        self._directions = self._beam_directions(n, angle_min, increment)
        self._delays = beam_time_offsets(*geometry)
        last = angle_min + increment * (n - 1)
        self.views = views_without(self._mount, angle_min, last, (*self._ignored, *self._hidden))

    def in_view(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return (n,) which points (n, 2), m, base_link, are in the latest scan's field of view."""
        seen = np.zeros(len(points), dtype=np.bool_)
        for view in self.views:
            seen |= view.mask(points)
        return seen

    def has_measured(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return (n,) which points (n, 2), m, base_link, the latest scan has measured or replaced.

        They are in its field of view, and the nearest beam has a return. A beam without one says
        nothing: dark, shiny and dazzling surfaces look like free space.
        """
        measured = self.in_view(points)
        if self._geometry is None or self._hit.all():
            return measured
        beam = np.rint(self._beams_to(points)[0]).astype(np.intp)
        measured &= self._hit.take(beam, mode="clip")
        return measured

    def goes_beyond(self, points: NDArray[np.float64], aside: float) -> NDArray[np.float64]:
        """Return how far, m, beams of the latest scan go on beyond each of points (n, 2), m.

        The least of all beams within aside, m, of a point, in base_link. -inf where one of them is
        out of view or has no return, which says nothing.
        """
        if self._geometry is None:
            return np.full(len(points), -math.inf)
        beams, away = self._beams_to(points)
        width = aside / np.maximum(away, aside or math.inf) / self._geometry[2]
        first = np.rint(beams - width).astype(np.intp)
        last = np.rint(beams + width).astype(np.intp)
        told = self.in_view(points) & (first >= 0) & (last < len(self._hit))
        least = np.full(len(points), -math.inf)
        if told.any():
            ranges = np.append(np.where(self._hit, self._ranges, -math.inf), math.inf)
            spans = np.column_stack((first[told], last[told] + 1)).ravel()
            least[told] = np.minimum.reduceat(ranges, spans)[::2] - away[told]
        return least

    def _beams_to(
        self, points: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return number and fraction of the beam to, and distance, m, of each of points (n, 2)."""
        assert self._geometry is not None
        _, first, increment, *_ = self._geometry
        x, y = (points - (self._mount.x, self._mount.y)).T
        bearing = np.arctan2(y, x) - self._mount.theta - first
        return bearing % math.tau / increment, np.hypot(x, y)

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

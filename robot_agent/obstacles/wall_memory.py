"""Walls the robot has just passed, as measured by its laser and independent of the pose's error.

The map has the walls behind the robot as well, but only as precisely as the pose: in a door, 0.05 m
decide whether the robot can turn or touches its frame.
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np
from numpy.typing import NDArray

from maps.pose import Pose
from robot_agent.motion.footprint import Footprint
from robot_agent.motion.gate_limits import GateLimits
from robot_agent.perception.scan_points import move_points

_NEAR = 0.8  # m round the robot; points farther away are seen again or do not matter
_BEYOND = 0.4  # m at least beyond the corners' reach
_STEP = 0.04  # m between two scans that are kept
_KEPT_WAY = 1.5  # m driven until a scan is dropped; odometry is precise enough up to here
_CELL = 0.05  # m; the points of a wall within a cell are averaged
_MIN_POINTS = 3  # in a cell; the mean of fewer is too noisy
_SHARE = 0.5  # of the median number in a cell; cells with less hold mainly noise
_MARGIN = 0.1  # m beyond the corners' reach in a turn in place
_NOTHING = np.empty((0, 2))


class WallMemory:
    """Keeps the walls near the robot of the last scans, transformed by odometry.

    The nearest of many points on a wall are too near by the laser's noise, and would pin a robot in
    a narrow place; means over cells are kept instead.
    """

    def __init__(self, gate: GateLimits) -> None:
        """Start without walls. gate: limits with the footprint."""
        self._footprint = Footprint(gate)
        self._reach = self._footprint.corner_reach + _MARGIN
        self._near = max(_NEAR, self._footprint.corner_reach + _BEYOND)
        self._way = 0.0  # m driven so far
        self._kept_at: Pose | None = None  # odom_from_base of the last scan kept
        self._scans: deque[tuple[float, NDArray[np.float64]]] = deque()  # way, points in odom
        self._walls = _NOTHING  # means over all scans, in odom

    def update(self, odometry: Pose, walls: NDArray[np.float64]) -> None:
        """Store a scan's points on walls, (n, 2), m, base_link; odometry: odom_from_base."""
        if self._kept_at is not None:
            driven = math.hypot(odometry.x - self._kept_at.x, odometry.y - self._kept_at.y)
            if driven < _STEP:
                return
            self._way += driven
        self._kept_at = odometry
        x, y = walls.T
        near = walls[x * x + y * y < self._near**2]
        if len(near):
            self._scans.append((self._way, move_points(near, odometry)))
        while self._scans and self._way - self._scans[0][0] > _KEPT_WAY:
            self._scans.popleft()
        seen = [points for _, points in self._scans]
        self._walls = _means(np.concatenate(seen)) if seen else _NOTHING

    def forget(self) -> None:
        """Drop all walls, as when the robot may have been carried."""
        self._scans.clear()
        self._kept_at, self._walls = None, _NOTHING

    def around(self, odometry: Pose) -> NDArray[np.float64]:
        """Return points (n, 2), m, in base_link at odometry, odom_from_base.

        Points inside the footprint are left out.
        """
        if not len(self._walls):
            return _NOTHING  # the usual case
        points = move_points(self._walls, odometry.inverse())
        x, y = points.T
        near = x * x + y * y < self._reach * self._reach
        return np.asarray(points[near & ~self._footprint.covers(points)])


def _means(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return (m, 2): the means of points (n, 2) in each cell that has enough of them."""
    cells = np.floor(points / _CELL).astype(np.int64)
    _, which, counts = np.unique(
        cells[:, 0] * 1_000_003 + cells[:, 1], return_inverse=True, return_counts=True
    )
    x, y = (np.bincount(which, weights=column) for column in points.T)
    enough = counts >= max(_MIN_POINTS, _SHARE * float(np.median(counts)))
    return np.asarray(np.column_stack((x, y))[enough] / counts[enough, None])

"""Walls the robot has just passed, as its laser saw them: where the pose errs, they do not.

The map tells of the walls behind as well, but no better than the pose is: in a door, 0.05 m are
the difference between turning and touching its frame.
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

_NEAR = 0.8  # m about the robot; what is farther off is seen again, or does not matter
_STEP = 0.04  # m between two scans that are kept
_KEPT_WAY = 1.5  # m driven until a scan is forgotten: odometry is that good
_CELL = 0.05  # m; what was seen of a wall within it is taken together
_LEAST = 3  # points in a cell; of fewer, noise is too much
_SHARE = 0.5  # of the usual number in a cell: it holds more of a wall than its noise
_MARGIN = 0.1  # m beyond what the corners reach in a turn on the spot
_NOTHING = np.empty((0, 2))


class WallMemory:
    """Keeps what the last scans saw of walls near by, carried along by odometry.

    Of many points on a wall the nearest are too near by the laser's noise, and would pin a robot
    in a narrow place: their means are kept.
    """

    def __init__(self, gate: GateLimits) -> None:
        """Nothing has been passed yet."""
        self._footprint = Footprint(gate)
        self._reach = self._footprint.corner_reach + _MARGIN
        self._way = 0.0  # m driven so far
        self._kept_at: Pose | None = None  # odom_from_base of the last scan kept
        self._scans: deque[tuple[float, NDArray[np.float64]]] = deque()  # way, points in odom
        self._walls = _NOTHING  # means of them all, in odom

    def update(self, odometry: Pose, walls: NDArray[np.float64]) -> None:
        """Take a scan's points on walls, (n, 2), m, base_link at odom_from_base."""
        if self._kept_at is not None:
            driven = math.hypot(odometry.x - self._kept_at.x, odometry.y - self._kept_at.y)
            if driven < _STEP:
                return
            self._way += driven
        self._kept_at = odometry
        x, y = walls.T
        near = walls[x * x + y * y < _NEAR * _NEAR]
        if len(near):
            self._scans.append((self._way, move_points(near, odometry)))
        while self._scans and self._way - self._scans[0][0] > _KEPT_WAY:
            self._scans.popleft()
        seen = [points for _, points in self._scans]
        self._walls = _means(np.concatenate(seen)) if seen else _NOTHING

    def forget(self) -> None:
        """Know of none: the robot may have been carried off."""
        self._scans.clear()
        self._kept_at, self._walls = None, _NOTHING

    def around(self, odometry: Pose) -> NDArray[np.float64]:
        """Return points (n, 2), m, in base_link where odometry is odom_from_base.

        What the body would stand in is left out.
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
    enough = counts >= max(_LEAST, _SHARE * float(np.median(counts)))
    return np.asarray(np.column_stack((x, y))[enough] / counts[enough, None])

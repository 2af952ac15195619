"""Walls the robot has just passed, as its laser saw them: where the pose errs, they do not.

The map tells of the walls behind as well, but no better than the pose is: in a door, 0.05 m are
the difference between turning and touching its frame.
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np
from numpy.typing import NDArray

from maps.occupancy_map import OccupancyMap
from maps.pose import Pose
from robot_agent.motion.gate_settings import GateSettings
from robot_agent.scan_points import move_points

_OF_WALL = 0.15  # m from a wall of the map: it will still stand there when it is out of sight
_NEAR = 0.8  # m about the robot; what is farther off is seen again, or does not matter
_STEP = 0.04  # m between two scans that are kept
_KEPT_WAY = 1.5  # m driven until a scan is forgotten: odometry is that good
_MARGIN = 0.1  # m beyond what the corners reach in a turn on the spot
_NOTHING = np.empty((0, 2))


class PassedWalls:
    """Keeps what the last scans saw of the map's walls near by, carried along by odometry."""

    def __init__(self, occupancy: OccupancyMap, gate: GateSettings) -> None:
        self._of_wall = occupancy.distance_field() <= _OF_WALL
        self._resolution = occupancy.resolution
        self._origin = occupancy.origin
        self._gate = gate
        self._reach = math.hypot(max(gate.front, gate.rear), gate.half_width) + _MARGIN
        self._way = 0.0  # m driven so far
        self._kept_at: Pose | None = None  # odom_from_base of the last scan kept
        self._scans: deque[tuple[float, NDArray[np.float64]]] = deque()  # way, points in odom
        self._points = _NOTHING  # all of them

    def see(self, odometry: Pose, localized: Pose | None, points: NDArray[np.float64]) -> None:
        """Take a scan's points (n, 2), m, base_link at odom_from_base.

        localized: map_from_base; None: nobody knows what is a wall, and what was kept may be gone.
        """
        if localized is None:
            self._scans.clear()
            self._kept_at, self._points = None, _NOTHING
            return
        if self._kept_at is not None:
            driven = math.hypot(odometry.x - self._kept_at.x, odometry.y - self._kept_at.y)
            if driven < _STEP:
                return
            self._way += driven
        self._kept_at = odometry
        x, y = points.T
        near = points[x * x + y * y < _NEAR * _NEAR]
        walls = near[self._are_of_wall(move_points(near, localized))]
        self._scans.append((self._way, move_points(walls, odometry)))
        while self._way - self._scans[0][0] > _KEPT_WAY:
            self._scans.popleft()
        self._points = np.concatenate([scan for _, scan in self._scans])

    def behind(self, odometry: Pose) -> NDArray[np.float64]:
        """Return points (n, 2), m, in base_link where odometry is odom_from_base.

        Behind the axle only: the laser looks at the rest. What the body would stand in is left out.
        """
        if not len(self._points):
            return _NOTHING  # the usual case
        points = move_points(self._points, odometry.inverse())
        x, y = points.T
        gate = self._gate
        outside = (x <= -gate.rear) | (np.abs(y) >= gate.half_width)
        taken = (x < 0.0) & (x * x + y * y < self._reach * self._reach) & outside
        return np.asarray(points[taken])

    def _are_of_wall(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Tell for points (n, 2), map frame, m, which lie at a wall of the map."""
        cells = np.floor((points - (self._origin.x, self._origin.y)) / self._resolution)
        cols, rows = cells.astype(np.intp).T
        height, width = self._of_wall.shape
        inside = (rows >= 0) & (rows < height) & (cols >= 0) & (cols < width)
        found = np.zeros(len(points), dtype=np.bool_)
        found[inside] = self._of_wall[rows[inside], cols[inside]]
        return found

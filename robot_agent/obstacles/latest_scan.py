"""What the latest scan saw in the way, carried along as the robot moves on."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from maps.pose import Pose
from robot_agent.perception.scan_points import move_points

REACH = 2.0
"""Points farther than this cannot matter to the gate: it stops within well under a metre."""


class Obstacles:
    """Points near the robot, in ``odom`` as measured, in ``base_link`` as asked for."""

    def __init__(self) -> None:
        """Nothing has been seen yet."""
        self.seen_at: float | None = None
        self._odom_from_scan = Pose(0.0, 0.0, 0.0)
        self._points = np.empty((0, 2))

    def update(self, t: float, odometry: Pose, points: NDArray[np.float64]) -> None:
        """Take a scan's points (n, 2), m, base_link at t, where odometry was odom_from_base."""
        self.seen_at = t
        self._odom_from_scan = odometry
        x, y = points.T
        self._points = points[x * x + y * y < REACH**2]

    def around(self, odometry: Pose) -> NDArray[np.float64]:
        """Return the points (n, 2), m, in base_link where odometry is odom_from_base."""
        return move_points(self._points, odometry.between(self._odom_from_scan))

    def from_scan(self, odometry: Pose, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return points (n, 2), m, in base_link at odom_from_base, as of the scan's pose."""
        return move_points(points, self._odom_from_scan.between(odometry))

"""Obstacle points of the latest scan, transformed by odometry as the robot moves on."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from maps.pose import Pose
from robot_agent.perception.scan_points import move_points

REACH = 2.0
"""m; points farther away cannot matter to the gate, which stops the robot within under 1 m."""


class Obstacles:
    """Points near the robot: stored with their pose in ``odom``, returned in ``base_link``.

    ``seen_at`` is when the scan was measured; None before the first.
    """

    def __init__(self) -> None:
        """Start without points."""
        self.seen_at: float | None = None
        self._odom_from_scan = Pose(0.0, 0.0, 0.0)
        self._points = np.empty((0, 2))

    def update(self, t: float, odometry: Pose, points: NDArray[np.float64]) -> None:
        """Store a scan's points (n, 2), m, base_link at t; odometry: odom_from_base at t."""
        self.seen_at = t
        self._odom_from_scan = odometry
        x, y = points.T
        self._points = points[x * x + y * y < REACH**2]

    def around(self, odometry: Pose) -> NDArray[np.float64]:
        """Return the points (n, 2), m, in base_link at odometry, odom_from_base."""
        return move_points(self._points, odometry.between(self._odom_from_scan))

    def from_scan(self, odometry: Pose, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Transform points (n, 2), m, from base_link at odom_from_base to base_link at the scan."""
        return move_points(points, self._odom_from_scan.between(odometry))

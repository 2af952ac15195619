"""Memory of points near the robot that the laser measures no longer.

The laser covers half of all directions and the sonars little of the rest. A person close beside a
robot that turns in place leaves its field of view just before a rear corner comes round.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from maps.pose import Pose
from robot_agent.motion.footprint import Footprint
from robot_agent.motion.gate_limits import GateLimits
from robot_agent.perception.scan_points import move_points

MEMORY = 60.0
"""s a point is kept out of view, longer than robots stand before things that hold them. It may have
left unseen, and must not hold the robot for good; a robot that is held turns the other way sooner,
which brings the place into view."""
_BEYOND = 0.2  # m beyond the corners' reach in a turn in place
_ORIGIN = Pose(0.0, 0.0, 0.0)


class RecentScanMemory:
    """Points out of view, stored in ``odom`` with the time they left it."""

    def __init__(self, gate: GateLimits) -> None:
        """Start without points. gate: limits with the footprint."""
        self._footprint = Footprint(gate)
        self._turn_margin = gate.turn_margin
        self._reach = self._footprint.corner_reach + _BEYOND
        self._points = np.empty((0, 2))
        self._lost_at = np.empty(0)
        self.lasts = False
        """Whether points are kept regardless of age: without a pose the map's walls are missing."""

    def update(
        self,
        t: float,
        odometry: Pose,
        seen_before: NDArray[np.float64],
        measured: Callable[[NDArray[np.float64]], NDArray[np.bool_]],
    ) -> None:
        """Store points of the scan before the one at t that are out of view now.

        odometry: odom_from_base at t. seen_before: points (n, 2), m, base_link at t. measured:
        returns (n,) which points (n, 2) lie where the new scan measured something; those are
        dropped, as it replaces them. Points within the turn margin of the footprint when they leave
        the view are dropped too: they would only pin the robot.
        """
        kept = move_points(self._points, odometry.between(_ORIGIN))
        fresh = seen_before[~self._footprint.covers(seen_before, self._turn_margin)]
        points = np.concatenate((kept, fresh))
        lost_at = np.concatenate((self._lost_at, np.full(len(fresh), t)))
        matters = (
            (np.hypot(points[:, 0], points[:, 1]) < self._reach)
            & ((t - lost_at <= MEMORY) | self.lasts)
            & ~measured(points)
        )
        self._points = move_points(points[matters], odometry)
        self._lost_at = lost_at[matters]

    def around(self, odometry: Pose) -> NDArray[np.float64]:
        """Return the points (n, 2), m, in base_link at odometry, odom_from_base."""
        return move_points(self._points, odometry.between(_ORIGIN))

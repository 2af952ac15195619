"""What the laser saw beside the robot before it turned or drove on, so that it looks there no more.

The laser sees half of all directions and the sonars little of the rest. Somebody who stands close
beside a robot that turns on the spot would leave its sight just before a rear corner comes round.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from maps.pose import Pose
from robot_agent.motion.footprint import Footprint
from robot_agent.motion.gate_limits import GateLimits
from robot_agent.perception.scan_points import move_points

MEMORY = 5.0
"""s. Whoever was there may have gone unseen, and must not hold the robot for good; one that is
held turns the other way before, and then sees."""
_BEYOND = 0.2  # m beyond what the corners reach in a turn on the spot
_ORIGIN = Pose(0.0, 0.0, 0.0)


class RecentScanMemory:
    """Points in ``odom`` as last seen, in ``base_link`` as asked for; dated when they were lost."""

    def __init__(self, gate: GateLimits) -> None:
        """Nothing has been seen yet."""
        self._footprint = Footprint(gate)
        self._turn_margin = gate.turn_margin
        self._reach = self._footprint.corner_reach + _BEYOND
        self._points = np.empty((0, 2))
        self._lost_at = np.empty(0)
        self.lasts = False
        """Whether nothing is forgotten for its age: who knows no pose knows no wall by the map."""

    def update(
        self,
        t: float,
        odometry: Pose,
        seen_before: NDArray[np.float64],
        in_view: Callable[[NDArray[np.float64]], NDArray[np.bool_]],
    ) -> None:
        """Take what the scan before the one at t, s, saw: points (n, 2), m, in base_link now.

        odometry: odom_from_base at t. in_view: which points (n, 2) lie where the laser looks; they
        are forgotten, as the new scan tells. Points that are as good as in the body when it stops
        seeing them are left out: they would only pin it.
        """
        kept = move_points(self._points, odometry.between(_ORIGIN))
        fresh = seen_before[~self._footprint.covers(seen_before, self._turn_margin)]
        points = np.concatenate((kept, fresh))
        lost_at = np.concatenate((self._lost_at, np.full(len(fresh), t)))
        matters = (
            (np.hypot(points[:, 0], points[:, 1]) < self._reach)
            & ((t - lost_at <= MEMORY) | self.lasts)
            & ~in_view(points)
        )
        self._points = move_points(points[matters], odometry)
        self._lost_at = lost_at[matters]

    def around(self, odometry: Pose) -> NDArray[np.float64]:
        """Return the points (n, 2), m, in base_link where odometry is odom_from_base."""
        return move_points(self._points, odometry.between(_ORIGIN))

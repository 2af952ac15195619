"""A trajectory: poses at some times, carried between them by the odometry."""

from __future__ import annotations

import bisect
import math
from collections.abc import Sequence

from maps.pose import Pose, wrap_angle

_TURN_ARM = 0.5  # m; a turn of one radian makes as much odometry error as this way


class Trajectory:
    """Poses at any time between the first and the last fixed one.

    Between two fixed poses the raw odometry gives the shape; what it is off at the second one is
    spread over the way in proportion to the motion.
    """

    def __init__(
        self, fixed: Sequence[tuple[float, Pose]], odometry: Sequence[tuple[float, Pose]]
    ) -> None:
        """Take map poses and odometry poses of the laser, both at increasing times, s.

        The odometry covers at least the fixed poses' times.
        """
        self._times, self._poses = [t for t, _ in fixed], [pose for _, pose in fixed]
        self._odometry_times = [t for t, _ in odometry]
        self._odometry = [pose for _, pose in odometry]
        self._way = [0.0]
        for last, pose in zip(self._odometry, self._odometry[1:], strict=False):
            turn = abs(wrap_angle(pose.theta - last.theta))
            self._way.append(self._way[-1] + math.dist(pose[:2], last[:2]) + _TURN_ARM * turn)

    def at(self, t: float) -> Pose | None:
        """Return map_from_laser at a time; None outside the fixed poses."""
        if not self._times[0] <= t <= self._times[-1]:
            return None
        index = min(bisect.bisect_right(self._times, t), len(self._times) - 1) - 1
        start, end = self._times[index], self._times[index + 1]
        (from_way, from_odometry), (to_way, to_odometry) = self._raw(start), self._raw(end)
        way, odometry = self._raw(t)
        share = (way - from_way) / (to_way - from_way) if to_way > from_way else 0.0
        moved = self._poses[index].compose(from_odometry.between(odometry))
        reached = self._poses[index].compose(from_odometry.between(to_odometry))
        target = self._poses[index + 1]
        return Pose(
            moved.x + share * (target.x - reached.x),
            moved.y + share * (target.y - reached.y),
            wrap_angle(moved.theta + share * wrap_angle(target.theta - reached.theta)),
        )

    def _raw(self, t: float) -> tuple[float, Pose]:
        """Return the way gone and the odometry at a time."""
        right = bisect.bisect_left(self._odometry_times, t)
        if right < len(self._odometry) and self._odometry_times[right] == t:
            return self._way[right], self._odometry[right]
        right = min(max(right, 1), len(self._odometry) - 1)
        left = right - 1
        before, after = self._odometry_times[left], self._odometry_times[right]
        share = (t - before) / (after - before)
        a, b = self._odometry[left], self._odometry[right]
        pose = Pose(
            a.x + share * (b.x - a.x),
            a.y + share * (b.y - a.y),
            wrap_angle(a.theta + share * wrap_angle(b.theta - a.theta)),
        )
        return self._way[left] + share * (self._way[right] - self._way[left]), pose

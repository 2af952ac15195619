"""A trajectory: fixed poses, interpolated by the odometry."""

from __future__ import annotations

import bisect
import itertools
import math
from collections.abc import Mapping, Sequence

from maps.pose import Pose, wrap_angle

_TURN_ARM = 0.5  # m; a radian counts as this distance for the odometry's error


class Trajectory:
    """Poses at any time between the first and the last fixed one.

    Between two fixed poses the raw odometry gives the shape; its error at the second one is
    distributed in proportion to the motion.
    """

    def __init__(self, odometry: Sequence[tuple[float, Pose]], fixed: Mapping[int, Pose]) -> None:
        """Take the odometry and the fixed poses, map_from_laser, by their index in it.

        odometry: stamps, s, and odom_from_laser in the order of motion; the stamps may be out of
        order. The first and the last fixed pose bound the trajectory.
        """
        self.poses: dict[int, Pose] = {}
        """map_from_laser by index in the odometry."""
        marks = sorted(fixed)
        self.poses[marks[0]] = fixed[marks[0]]
        for start, end in itertools.pairwise(marks):
            raw = [pose for _, pose in odometry[start : end + 1]]
            carried = _carry(raw, fixed[start], fixed[end])
            self.poses.update(enumerate(carried, start=start))
        stamped = sorted((odometry[index][0], index) for index in self.poses)
        self.times = [t for t, _ in stamped]
        """The odometry's stamps, s, sorted."""
        self._stamped = [self.poses[index] for _, index in stamped]

    def at(self, t: float) -> Pose | None:
        """Return map_from_laser at ``t``; None outside the fixed poses."""
        if not self.times[0] <= t <= self.times[-1]:
            return None
        right = bisect.bisect_left(self.times, t)
        if self.times[right] == t:
            return self._stamped[right]
        before, after = self.times[right - 1], self.times[right]
        return _between(
            self._stamped[right - 1], self._stamped[right], (t - before) / (after - before)
        )


def _carry(raw: Sequence[Pose], start: Pose, end: Pose) -> list[Pose]:
    """Return a stretch of odometry fitted to its fixed start and end."""
    way = [0.0]
    for last, pose in itertools.pairwise(raw):
        turn = abs(wrap_angle(pose.theta - last.theta))
        way.append(way[-1] + math.dist(pose[:2], last[:2]) + _TURN_ARM * turn)
    carried = [start.compose(raw[0].between(pose)) for pose in raw]
    off = (
        end.x - carried[-1].x,
        end.y - carried[-1].y,
        wrap_angle(end.theta - carried[-1].theta),
    )
    shares = [gone / way[-1] if way[-1] > 0.0 else 0.0 for gone in way]
    laid = [
        Pose(
            pose.x + share * off[0],
            pose.y + share * off[1],
            wrap_angle(pose.theta + share * off[2]),
        )
        for pose, share in zip(carried, shares, strict=True)
    ]
    return [*laid[:-1], end]


def _between(a: Pose, b: Pose, share: float) -> Pose:
    return Pose(
        a.x + share * (b.x - a.x),
        a.y + share * (b.y - a.y),
        wrap_angle(a.theta + share * wrap_angle(b.theta - a.theta)),
    )

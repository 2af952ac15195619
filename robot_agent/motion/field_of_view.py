"""Field of view of a sensor: the sector in base_link within which obstacles are detected."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from maps.pose import Pose


class FieldOfView(NamedTuple):
    """Sector about an axis.

    x, y: apex in base_link, m. theta: direction of the axis, rad. half_angle: to each side of the
    axis, rad. reach: m.
    """

    x: float
    y: float
    theta: float
    half_angle: float
    reach: float

    def covers(self, x: float, y: float) -> bool:
        """Return whether a position (x, y), m, base_link, is in the sector."""
        dx, dy = x - self.x, y - self.y
        off = math.remainder(math.atan2(dy, dx) - self.theta, math.tau)
        return abs(off) <= self.half_angle and math.hypot(dx, dy) <= self.reach

    def mask(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return (n,) which points (n, 2), m, base_link, are in the sector."""
        dx, dy = points[:, 0] - self.x, points[:, 1] - self.y
        off = np.arctan2(dy, dx) - self.theta
        off -= math.tau * np.round(off / math.tau)
        return np.asarray((np.abs(off) <= self.half_angle) & (np.hypot(dx, dy) <= self.reach))


def views_without(
    apex: Pose,
    first: float,
    last: float,
    ignored: Sequence[tuple[float, float]],
    reach: float = math.inf,
) -> tuple[FieldOfView, ...]:
    """Return the sectors from first to last, rad from the apex's theta, less the ignored ones.

    ignored: first and last direction of each, rad likewise. reach: m.
    """
    views = []
    for start, end in (*sorted(ignored), (last, math.inf)):
        if min(start, last) > first:
            half = 0.5 * (min(start, last) - first)
            views.append(FieldOfView(apex.x, apex.y, apex.theta + first + half, half, reach))
        first = max(first, end)
    return tuple(views)


def are_covered(places: Iterable[tuple[float, float]], views: Sequence[FieldOfView]) -> bool:
    """Return whether each of some positions (x, y), m, base_link, is in a field of view."""
    for x, y in places:
        for view in views:
            if view.covers(x, y):
                break
        else:
            return False
    return True

"""Field of view of a sensor: the sector in base_link within which obstacles are detected."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple


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


def is_covered(x: float, y: float, views: Sequence[FieldOfView]) -> bool:
    """Return whether any of the fields of view covers a position (x, y), m, base_link."""
    return any(view.covers(x, y) for view in views)

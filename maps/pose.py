"""Planar poses: (x, y, theta) in metres and radians, REP-103 axes, angles wrapped to (-pi, pi]."""

from __future__ import annotations

import math
from typing import NamedTuple


def wrap_angle(angle: float) -> float:
    """Wrap an angle in rad to (-pi, pi]."""
    wrapped = math.remainder(angle, math.tau)
    return math.pi if wrapped == -math.pi else wrapped


class Pose(NamedTuple):
    """A rigid transform in the plane; name the variable by its frames, e.g. ``map_from_base``.

    x, y in m, theta in rad, counter-clockwise positive.
    """

    x: float
    y: float
    theta: float

    def compose(self, other: Pose) -> Pose:
        """Chain transforms: ``a_from_b.compose(b_from_c)`` is ``a_from_c``."""
        c, s = math.cos(self.theta), math.sin(self.theta)
        return Pose(
            self.x + c * other.x - s * other.y,
            self.y + s * other.x + c * other.y,
            wrap_angle(self.theta + other.theta),
        )

    def inverse(self) -> Pose:
        """Return ``b_from_a`` of ``a_from_b``."""
        c, s = math.cos(self.theta), math.sin(self.theta)
        return Pose(-c * self.x - s * self.y, s * self.x - c * self.y, wrap_angle(-self.theta))

    def between(self, other: Pose) -> Pose:
        """Return ``other`` relative to this pose: ``self.inverse().compose(other)``."""
        return self.inverse().compose(other)

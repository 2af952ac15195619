"""Primitives of a border: straight segments and circular arcs, each with a direction."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Segment:
    """A straight piece from ``start`` to ``end``, m in the map frame."""

    start: Point
    end: Point

    @property
    def length(self) -> float:
        """Length, m."""
        return math.dist(self.start, self.end)

    @property
    def heading(self) -> float:
        """Direction of travel, rad."""
        return math.atan2(self.end[1] - self.start[1], self.end[0] - self.start[0])

    start_heading = heading
    end_heading = heading

    @property
    def curvature(self) -> float:
        """Zero, 1/m."""
        return 0.0

    def reversed(self) -> Segment:
        """Return the same piece in the opposite direction."""
        return Segment(self.end, self.start)

    def points(self, u: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return (n, 2) the points at distances u (n,) m from the start."""
        ratio = (u / self.length)[:, None]
        return np.asarray(self.start) * (1.0 - ratio) + np.asarray(self.end) * ratio


@dataclass(frozen=True, slots=True)
class Arc:
    """A circular piece: from ``start_angle`` round ``center`` by ``sweep`` (positive = left turn).

    center, radius in m in the map frame; start_angle and sweep in rad.
    """

    center: Point
    radius: float
    start_angle: float
    sweep: float

    @property
    def start(self) -> Point:
        """First point, m."""
        return self._at_angle(self.start_angle)

    @property
    def end(self) -> Point:
        """Last point, m."""
        return self._at_angle(self.start_angle + self.sweep)

    @property
    def length(self) -> float:
        """Length, m."""
        return self.radius * abs(self.sweep)

    @property
    def turn(self) -> float:
        """+1 for a left turn, -1 for a right one."""
        return math.copysign(1.0, self.sweep)

    @property
    def start_heading(self) -> float:
        """Direction of travel at the first point, rad."""
        return self.start_angle + self.turn * math.pi / 2

    @property
    def end_heading(self) -> float:
        """Direction of travel at the last point, rad."""
        return self.start_heading + self.sweep

    @property
    def curvature(self) -> float:
        """Signed curvature, 1/m, positive for a left turn."""
        return self.turn / self.radius

    def reversed(self) -> Arc:
        """Return the same piece in the opposite direction."""
        return Arc(self.center, self.radius, self.start_angle + self.sweep, -self.sweep)

    def points(self, u: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return (n, 2) the points at distances u (n,) m from the start."""
        angle = self.start_angle + u * self.curvature
        unit = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        return np.asarray(self.center) + self.radius * unit

    def _at_angle(self, angle: float) -> Point:
        return (
            self.center[0] + self.radius * math.cos(angle),
            self.center[1] + self.radius * math.sin(angle),
        )


Primitive = Segment | Arc

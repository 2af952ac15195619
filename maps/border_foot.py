"""Primitives placed at an abscissa and prepared for fast projection onto them."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from maps.border_primitives import Arc, Segment


class BorderPoint(NamedTuple):
    """A point of the border: m in the map frame, unit tangent along +s, curvature 1/m (+ left)."""

    x: float
    y: float
    tx: float
    ty: float
    curvature: float


class SegmentFoot:
    """A segment prepared for projection, placed at an abscissa."""

    __slots__ = ("length", "s0", "tx", "ty", "x0", "y0")

    def __init__(self, segment: Segment, s0: float) -> None:
        self.s0 = s0
        self.length = segment.length
        self.x0, self.y0 = segment.start
        self.tx = (segment.end[0] - self.x0) / self.length
        self.ty = (segment.end[1] - self.y0) / self.length

    def nearest(self, x: float, y: float) -> tuple[float, float]:
        """Return (distance, abscissa) of the point nearest to (x, y)."""
        dx, dy = x - self.x0, y - self.y0
        along = dx * self.tx + dy * self.ty
        if along < 0.0:
            return math.hypot(dx, dy), self.s0
        if along > self.length:
            along = self.length
            return math.hypot(dx - along * self.tx, dy - along * self.ty), self.s0 + along
        return abs(dy * self.tx - dx * self.ty), self.s0 + along

    def nearest_many(
        self, xy: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return (distances (n,), abscissae (n,)) of the points nearest to xy (n, 2)."""
        dx, dy = xy[:, 0] - self.x0, xy[:, 1] - self.y0
        along = np.clip(dx * self.tx + dy * self.ty, 0.0, self.length)
        return np.hypot(dx - along * self.tx, dy - along * self.ty), self.s0 + along

    def at(self, s: float) -> BorderPoint:
        """Return the point at abscissa s."""
        along = s - self.s0
        return BorderPoint(
            self.x0 + along * self.tx, self.y0 + along * self.ty, self.tx, self.ty, 0.0
        )


class ArcFoot:
    """An arc prepared for projection, placed at an abscissa."""

    __slots__ = ("curvature", "cx", "cy", "ends", "half", "middle", "radius", "s_middle", "turn")

    def __init__(self, arc: Arc, s0: float) -> None:
        self.cx, self.cy = arc.center
        self.radius, self.turn, self.curvature = arc.radius, arc.turn, arc.curvature
        self.half = abs(arc.sweep) / 2
        self.middle = arc.start_angle + arc.sweep / 2
        self.s_middle = s0 + arc.length / 2
        ends = (arc.start, arc.end)
        self.ends = ends if arc.sweep < 0.0 else ends[::-1]  # at +half, at -half

    def nearest(self, x: float, y: float) -> tuple[float, float]:
        """Return (distance, abscissa) of the point nearest to (x, y)."""
        dx, dy = x - self.cx, y - self.cy
        angle = math.remainder(math.atan2(dy, dx) - self.middle, math.tau)
        if -self.half <= angle <= self.half:
            s = self.s_middle + self.radius * self.turn * angle
            return abs(math.hypot(dx, dy) - self.radius), s
        angle, end = (self.half, self.ends[0]) if angle > 0.0 else (-self.half, self.ends[1])
        s = self.s_middle + self.radius * self.turn * angle
        return math.hypot(x - end[0], y - end[1]), s

    def nearest_many(
        self, xy: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return (distances (n,), abscissae (n,)) of the points nearest to xy (n, 2)."""
        dx, dy = xy[:, 0] - self.cx, xy[:, 1] - self.cy
        angle = np.arctan2(dy, dx) - self.middle
        angle -= math.tau * np.round(angle / math.tau)
        angle = np.clip(angle, -self.half, self.half)
        distance = np.hypot(
            dx - self.radius * np.cos(self.middle + angle),
            dy - self.radius * np.sin(self.middle + angle),
        )
        return distance, self.s_middle + self.radius * self.turn * angle

    def at(self, s: float) -> BorderPoint:
        """Return the point at abscissa s."""
        angle = self.middle + (s - self.s_middle) * self.curvature
        c, sine = math.cos(angle), math.sin(angle)
        return BorderPoint(
            self.cx + self.radius * c,
            self.cy + self.radius * sine,
            -self.turn * sine,
            self.turn * c,
            self.curvature,
        )

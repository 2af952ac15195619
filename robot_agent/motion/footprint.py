"""The footprint: the rectangle that the robot's body covers in base_link."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from robot_agent.motion.gate_limits import GateLimits


class Footprint:
    """Footprint of the body by the gate's limits; base_link is at the middle of the axle."""

    def __init__(self, limits: GateLimits) -> None:
        self._front = limits.front
        self._rear = limits.rear
        self._half_width = limits.half_width

    @property
    def half_width(self) -> float:
        """Distance, m, of the flanks from the middle of the axle."""
        return self._half_width

    @property
    def corner_reach(self) -> float:
        """Distance, m, of the farthest corner from the middle of the axle: its reach in a turn."""
        return math.hypot(max(self._front, self._rear), self._half_width)

    @property
    def front(self) -> float:
        """Distance, m, of the foremost edge from the middle of the axle."""
        return self._front

    @property
    def front_corner_reach(self) -> float:
        """Distance, m, of the front corners from the middle of the axle."""
        return math.hypot(self._front, self._half_width)

    @property
    def middle_offset(self) -> float:
        """Distance, m, of the body's middle from the middle of the axle."""
        return 0.5 * abs(self._rear - self._front)

    def covers(self, points: NDArray[np.float64], margin: float = 0.0) -> NDArray[np.bool_]:
        """Return (n,) which points (n, 2), m, base_link, are in the footprint plus margin, m."""
        x, y = points.T
        return np.asarray(
            (x < self._front + margin)
            & (x > -self._rear - margin)
            & (np.abs(y) < self._half_width + margin)
        )

    def nearer(
        self, points: NDArray[np.float64], error: float, margin: float
    ) -> NDArray[np.float64]:
        """Return points (n, 2), m, base_link, nearer to the footprint by an error, m.

        None comes nearer than margin, m, by that; those nearer already, or inside, stay.
        """
        x, y = points.T
        dx = x - np.clip(x, -self._rear, self._front)
        dy = y - np.clip(y, -self._half_width, self._half_width)
        away = np.hypot(dx, dy)
        left = np.maximum(away - error, np.minimum(away, margin))
        share = np.divide(away - left, away, out=np.zeros_like(away), where=away > 0.0)
        return np.column_stack((x - share * dx, y - share * dy))

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

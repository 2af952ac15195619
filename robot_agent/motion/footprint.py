"""The footprint: the rectangle round the axle's middle that the robot's body covers."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from robot_agent.motion.gate_limits import GateLimits


class Footprint:
    """The body as the gate knows it, in base_link."""

    def __init__(self, limits: GateLimits) -> None:
        self._front = limits.front
        self._rear = limits.rear
        self._half_width = limits.half_width

    @property
    def corner_reach(self) -> float:
        """How far, m, from the axle's middle the corners reach in a turn on the spot."""
        return math.hypot(max(self._front, self._rear), self._half_width)

    def covers(self, points: NDArray[np.float64], margin: float = 0.0) -> NDArray[np.bool_]:
        """Return (n,) which points (n, 2), m, base_link, are in the body with a margin, m."""
        x, y = points.T
        return np.asarray(
            (x < self._front + margin)
            & (x > -self._rear - margin)
            & (np.abs(y) < self._half_width + margin)
        )

"""Where the robot's own body is: the gate's rectangle round the axle's middle, in base_link."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from robot_agent.motion.gate_limits import GateLimits


def in_body(
    points: NDArray[np.float64], gate: GateLimits, margin: float = 0.0
) -> NDArray[np.bool_]:
    """Return (n,) which points (n, 2), m, base_link, are in the body with a margin, m, round it."""
    x, y = points.T
    return np.asarray(
        (x < gate.front + margin)
        & (x > -gate.rear - margin)
        & (np.abs(y) < gate.half_width + margin)
    )


def corner_reach(gate: GateLimits) -> float:
    """Return how far, m, from the axle's middle the corners reach in a turn on the spot."""
    return math.hypot(max(gate.front, gate.rear), gate.half_width)

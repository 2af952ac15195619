"""Room for people nearby: the laser sees two legs, the trunk and the feet reach farther.

A robot that turns in place beside a person would otherwise sweep its rear corner through the feet.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from robot_agent.motion.footprint import Footprint

RADIUS = 0.26
"""m round the middle of a person: half the breadth across the shoulders (0.23 m for 95 % of men,
ISO 7250-1's bideltoid breadth), as much as a foot reaches ahead of the ankle; and an error of the
track, ours."""
_STEPS = 12
_ANGLES = np.arange(_STEPS) * (math.tau / _STEPS)
_CIRCLE = RADIUS * np.column_stack((np.cos(_ANGLES), np.sin(_ANGLES)))


class PersonRoom:
    """Makes the circles round people; those inside the robot's footprint would only pin it."""

    def __init__(self, footprint: Footprint, margin: float) -> None:
        """Take the robot's footprint and the margin, m, that a turn in place keeps round it."""
        self._footprint = footprint
        self._margin = margin

    def around(self, middles: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return points (m, 2) on the circles round people's middles (n, 2), m, all in base_link.

        Points within the margin of the footprint are left out: a person that has come so near must
        not keep the robot from turning away.
        """
        points = (middles[:, None, :] + _CIRCLE).reshape(-1, 2)
        return points[~self._footprint.covers(points, self._margin)]

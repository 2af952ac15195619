"""Keep-out circle round each teammate nearby: the area its corners sweep in a turn in place.

Two robots that stop nose to nose and both turn would otherwise touch with their corners, outside
either one's field of view. A track gives the middle of a teammate's body; the robot turns about its
axle, which lies 0.046 m ahead of that in an unknown heading.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

RADIUS = 0.42
"""m round the middle of a Pioneer: its corners reach 0.369 m from the axle, which is 0.046 m from
the middle."""
_OWN = 0.40  # m round the axle; nearer points would only keep this robot from turning away
_STEPS = 16
_ANGLES = np.arange(_STEPS) * (math.tau / _STEPS)
_CIRCLE = RADIUS * np.column_stack((np.cos(_ANGLES), np.sin(_ANGLES)))


def teammate_keep_out(middles: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return points (m, 2) on the circles round robots' middles (n, 2), m, all in base_link.

    Points within this robot's own circle are left out, so that the keep-out zone stops robots from
    driving into it but never from turning away.
    """
    points = (middles[:, None, :] + _CIRCLE).reshape(-1, 2)
    return points[np.hypot(points[:, 0], points[:, 1]) > _OWN]

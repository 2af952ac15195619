"""Room for teammates near by: each may turn where it stands, and its corners sweep a circle.

Two robots that stop nose to nose and both turn round would otherwise touch with their corners,
which neither sees coming. Known is the middle of a teammate's body; it turns about its axle, which
lies 0.046 m before that, in whatever direction it faces.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

RADIUS = 0.42
"""m about the middle of a Pioneer: corners reach 0.369 m about the axle, and the axle lies 0.046 m
off the middle."""
_OWN = 0.40  # m about the axle; nearer points would only keep this robot from turning away
_STEPS = 16
_ANGLES = np.arange(_STEPS) * (math.tau / _STEPS)
_CIRCLE = RADIUS * np.column_stack((np.cos(_ANGLES), np.sin(_ANGLES)))


def teammate_keep_out(middles: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return points (m, 2) on the circles about robots' middles (n, 2), m, all in base_link.

    What lies within this robot's own circle is left out: it keeps others from driving into the
    circle, never anybody from turning out of it.
    """
    points = (middles[:, None, :] + _CIRCLE).reshape(-1, 2)
    return points[np.hypot(points[:, 0], points[:, 1]) > _OWN]

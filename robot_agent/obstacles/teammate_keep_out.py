"""Keep-out circle round each teammate nearby: the area its corners sweep in a turn in place.

Two robots that stop nose to nose and both turn would otherwise touch with their corners, outside
either one's field of view. A track gives the middle of a teammate's body; the robot turns about its
axle, which lies ahead of that (0.046 m in a 2-DX) in an unknown heading.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from robot_agent.motion.footprint import Footprint

_SWING = 0.2  # m, ours: more than a Pioneer's (0.18 m at most), less than a PowerBot's (0.30 m)
_OWN_MARGIN = 0.03  # m beyond the own corners' reach in a turn in place
_STEPS = 16
_ANGLES = np.arange(_STEPS) * (math.tau / _STEPS)
CIRCLE = np.column_stack((np.cos(_ANGLES), np.sin(_ANGLES)))


class TeammateKeepOut:
    """Makes the keep-out circles; teammates are taken to be of the robot's own size."""

    def __init__(self, footprint: Footprint) -> None:
        self._footprint = footprint
        reach = footprint.corner_reach
        self.long_body = reach - footprint.half_width > _SWING
        """Whether corners come out far beyond the flanks in a turn in place."""
        self.radius = _whole_centimetres(reach + footprint.middle_offset)
        """m round the middle of a teammate: its corners' reach from its axle, wherever that is."""
        self.own = _whole_centimetres(reach) + _OWN_MARGIN
        """m round the own axle within which no point beside or behind is kept."""
        self.own_ahead = _whole_centimetres(footprint.front_corner_reach) + _OWN_MARGIN
        """m likewise ahead, where a turn in place brings the front corners only."""

    def around(
        self, middles: NDArray[np.float64], passing: NDArray[np.bool_] | None = None
    ) -> NDArray[np.float64]:
        """Return points (m, 2) on the circles round robots' middles (n, 2), m, all in base_link.

        Points that this robot's corners reach in a turn are left out, so that the keep-out zone
        stops robots from driving into it but never from turning away; of robots that are
        ``passing`` (n,), None for none, only those within the footprint: a turn can wait until they
        have passed.
        """
        points = (middles[:, None, :] + self.radius * CIRCLE).reshape(-1, 2)
        kept = self.keeps(*points.T)
        if passing is not None:
            kept |= passing.repeat(_STEPS) & ~self._footprint.covers(points)
        return points[kept]

    def keeps(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return which points (x, y), m, base_link, lie beyond the reach of the own corners."""
        own = np.where(x > self._footprint.front, self.own_ahead, self.own)
        return np.asarray(np.hypot(x, y) > own)


def _whole_centimetres(metres: float) -> float:
    """Return a length rounded up."""
    return math.ceil(100.0 * metres) / 100.0

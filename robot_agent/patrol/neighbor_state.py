"""Neighbor state: the closest teammate relative to border and robot (eq. 13, corrected).

Corrections: the third case of eq. 13 is lambda, not 1; abscissae are compared round the seam of a
closed border; at equal abscissa the last side is kept; and a teammate near in space but far along
the border does not count as patrolling beside this robot.
"""

from __future__ import annotations

import math

import msgspec

from maps.border import Border, BorderProjection
from robot_agent.patrol.settings import PatrolSettings

SAME_PLACE = 0.05  # m of abscissa within which left and right keep their last value
# A teammate farther along the border than this many times the straight distance plus so many m is
# on another stretch.
DETOUR_RATIO = 1.6
DETOUR_ALLOWANCE = 1.0  # m
LEFT, RIGHT = -1, 1  # lambda of eq. 13: lower or higher abscissa, seen by a robot facing outwards


class NeighborView(msgspec.Struct, frozen=True):
    """Distance to the closest teammate, m (infinite if none), and gamma of eq. 13, -1 to 1."""

    distance: float
    gamma: float


NO_NEIGHBOR = NeighborView(math.inf, 0.0)


class NeighborState:
    """Computes the view of the closest teammate; keeps the side it was last on."""

    def __init__(self, settings: PatrolSettings, border: Border) -> None:
        self._settings = settings
        self._border = border
        self._side: int | None = None

    def view(
        self,
        position: tuple[float, float],
        foot: BorderProjection,
        teammate: tuple[float, float] | None,
    ) -> NeighborView:
        """Return the view of a teammate from a position; NO_NEIGHBOR if the teammate is None.

        position, teammate: (x, y), m, map frame. foot: projection of the position on the border.
        """
        if teammate is None:
            self._side = None
            return NO_NEIGHBOR
        distance = math.dist(position, teammate)
        from_border, abscissa = self._border.nearest(*teammate)
        delta = self._border.difference(abscissa, foot.abscissa)
        self._side = self._side_of(delta, foot, teammate)
        if abs(delta) > DETOUR_RATIO * distance + DETOUR_ALLOWANCE:
            return NeighborView(distance, 0.0)
        return NeighborView(distance, self._closeness(from_border) * self._side)

    def _closeness(self, distance_from_border: float) -> float:
        """Magnitude of eq. 13: 1 on the border, falling to 0 between the two thresholds."""
        near, far = self._settings.patrolling_distance, self._settings.passing_distance
        return min(max((far - distance_from_border) / (far - near), 0.0), 1.0)

    def _side_of(self, delta: float, own: BorderProjection, teammate: tuple[float, float]) -> int:
        if abs(delta) >= SAME_PLACE:
            return LEFT if delta < 0.0 else RIGHT
        if self._side is not None:
            return self._side
        other = self._border.project(*teammate)
        # Of two robots at one abscissa the outer one (left of a clockwise tangent) goes clockwise.
        return LEFT if own.side * own.distance > other.side * other.distance else RIGHT

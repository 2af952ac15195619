"""``NeighborState`` for many robots at once."""

from __future__ import annotations

import math

import numpy as np

from robot_agent.patrol.neighbor_state import (
    DETOUR_ALLOWANCE,
    DETOUR_RATIO,
    LEFT,
    RIGHT,
    SAME_PLACE,
)
from robot_agent.patrol.settings import PatrolSettings
from tools.batch.arrays import Flags, Indices, Reals, pick
from tools.batch.border_feet import BorderFeet


class NeighborStates:
    """Computes distance and gamma of each robot's closest teammate; keeps its side."""

    def __init__(self, settings: PatrolSettings, feet: BorderFeet, n: int) -> None:
        self._settings = settings
        self._feet = feet
        self._side = np.zeros(n, dtype=np.int8)  # 0: none yet

    def view(
        self, x: Reals, y: Reals, s: Reals, mate: Flags, mate_x: Reals, mate_y: Reals
    ) -> tuple[Reals, Reals]:
        """Return (distances, gammas), each (n,); infinite and 0 without a teammate."""
        n = len(x)
        distance, gamma = np.full(n, math.inf), np.zeros(n)
        self._side[~mate] = 0
        some = mate.nonzero()[0]
        if not some.size:
            return distance, gamma
        mx, my = mate_x[some], mate_y[some]
        apart = np.hypot(x[some] - mx, y[some] - my)
        from_border, abscissa = self._feet.nearest(mx, my)
        delta = self._feet.difference(abscissa, s[some])
        clear = np.abs(delta) >= SAME_PLACE
        side = np.where(clear, np.where(delta < 0.0, LEFT, RIGHT), self._side[some])
        for index in (side == 0).nonzero()[0].tolist():
            own = some[index]
            place = float(x[own]), float(y[own]), float(s[own])
            side[index] = self._outer_side(place, (float(mx[index]), float(my[index])))
        self._side[some] = side
        near, far = self._settings.patrolling_distance, self._settings.passing_distance
        closeness = np.minimum(np.maximum((far - from_border) / (far - near), 0.0), 1.0)
        elsewhere = np.abs(delta) > DETOUR_RATIO * apart + DETOUR_ALLOWANCE
        distance[some] = apart
        gamma[some] = np.where(elsewhere, 0.0, closeness * side)
        return distance, gamma

    def pick(self, robots: Indices) -> None:
        """Keep some robots, as ``arrays.pick`` does."""
        pick(self, ("_side",), robots)

    def _outer_side(self, place: tuple[float, float, float], mate: tuple[float, float]) -> int:
        """Return the side by which of two robots at one abscissa is the outer one.

        place: x, y and abscissa; mate: x, y; m.
        """
        own = self._offset(*place)
        other = self._offset(*mate, None)
        return LEFT if own > other else RIGHT

    def _offset(self, x: float, y: float, s: float | None) -> float:
        """Return a position's distance from the border, m, positive left of its tangent."""
        near = None if s is None else np.array([s])
        distance, abscissa = self._feet.nearest(np.array([x]), np.array([y]), near)
        foot_x, foot_y, tx, ty, _ = (float(each[0]) for each in self._feet.at(abscissa))
        side = 1.0 if tx * (y - foot_y) - ty * (x - foot_x) >= 0.0 else -1.0
        return side * float(distance[0])

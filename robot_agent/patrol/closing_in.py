"""Where robots always turn at each other nobody drives: now and then one comes closer there.

Not in the paper, whose robots turn back 1.9 m before each other and, equally fast, do so at the
same places again: among many, most of all among wrecks, the gaps between stay undriven for good.
One that teammates sent back at one place time after time tosses a coin. On heads it comes on
slowly next time, and turns closer to them; one that turned as ever is followed, and leaves its
place.
"""

from __future__ import annotations

from collections import deque

import numpy as np

from maps.border import Border
from robot_agent.patrol.neighbor_state import NeighborView

_TIMES = 3  # turns at one place before chance is asked
_ONE_PLACE = 0.5  # m of abscissa
_SLOW_FROM = 2.4  # m from a teammate; two that close in at 0.2 m/s stand 1.15 m apart in the end
# Distances, m, and what the rules are told instead. They avoid from 1.1 m and turn from 1.9 m on.
_IS = (1.1, 1.4, _SLOW_FROM)
_TOLD = (1.1, 1.9, _SLOW_FROM)


class ClosingIn:
    """Remembers where teammates sent the robot back, on either side of it."""

    def __init__(self, border: Border, rng: np.random.Generator, probability: float) -> None:
        """probability: of coming closer the next time; 0: never."""
        self._border = border
        self._rng = rng
        self._probability = probability
        self._places: dict[int, deque[float]] = {way: deque(maxlen=_TIMES) for way in (-1, 1)}
        self._closes_in = {-1: False, 1: False}

    def sent_back(self, abscissa: float, direction: int) -> None:
        """Note that at an abscissa, m, a teammate turned the robot from direction, +1 or -1."""
        places = self._places[direction]
        if places and abs(self._border.difference(places[-1], abscissa)) > _ONE_PLACE:
            places.clear()
        places.append(abscissa)
        asked = self._probability > 0.0 and len(places) == _TIMES
        self._closes_in[direction] = asked and float(self._rng.random()) < self._probability

    def told(self, neighbor: NeighborView, direction: int) -> NeighborView:
        """Return the view of the closest teammate that the rules are told, patrolling in direction.

        The view itself: nothing is different, the robot need not go slowly.
        """
        ahead = neighbor.gamma * direction > 0.0
        if not (ahead and self._closes_in[direction]) or neighbor.distance >= _SLOW_FROM:
            return neighbor
        return NeighborView(float(np.interp(neighbor.distance, _IS, _TOLD)), neighbor.gamma)

"""Where robots always turn at each other nobody drives: now and then one comes closer there.

Not in the paper, whose robots turn back 1.9 m before each other and, equally fast, do so at the
same places again: among many, most of all among wrecks, the gaps between stay undriven for good.
One that teammates sent back at one place time after time stands for a moment, as chance has it, so
that they no longer turn in step, and tosses a coin. On heads it comes on slowly next time, and
turns closer to them; one that turned as ever is followed, and leaves its place.
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from maps.border import Border
from robot_agent.patrol.actions import Action
from robot_agent.patrol.neighbor_state import NeighborView

_TIMES = 3  # turns at one place before chance is asked
_ONE_PLACE = 0.5  # m of abscissa
_SLOW_FROM = 2.4  # m from a teammate; two that close in at 0.2 m/s stand 1.15 m apart in the end
CLOSEST = 1.4  # m from a teammate, where one that closes in turns
# Distances, m, and what the rules are told instead. They avoid from 1.1 m and turn from 1.9 m on.
_IS = (1.1, CLOSEST, _SLOW_FROM)
_TOLD = (1.1, 1.9, _SLOW_FROM)


class ClosingIn:
    """Remembers where teammates sent the robot back, on either side of it."""

    def __init__(
        self, border: Border, rng: np.random.Generator, probability: float, longest_wait: float
    ) -> None:
        """probability: of coming closer the next time; 0: never, nor any wait of up to s."""
        self._border = border
        self._rng = rng
        self._probability = probability
        self._longest_wait = longest_wait
        self._places: dict[int, deque[float]] = {way: deque(maxlen=_TIMES) for way in (-1, 1)}
        self._closes_in = {-1: False, 1: False}
        self._waits_until = -math.inf  # s

    def sent_back(self, t: float, abscissa: float, direction: int) -> None:
        """Note that at t, s, a teammate turned the robot, at an abscissa, m, from direction."""
        places = self._places[direction]
        if places and abs(self._border.difference(places[-1], abscissa)) > _ONE_PLACE:
            places.clear()
        places.append(abscissa)
        again = self._probability > 0.0 and len(places) == _TIMES
        self._closes_in[direction] = again and float(self._rng.random()) < self._probability
        if again:
            self._waits_until = t + float(self._rng.uniform(0.0, self._longest_wait))

    def waits(self, t: float, action: Action) -> bool:
        """Tell whether the robot stands for a moment at t, s, if its action lets it."""
        return t < self._waits_until and action is not Action.AVOID_TEAMMATE

    def told(self, neighbor: NeighborView, direction: int | None) -> NeighborView:
        """Return the view of the closest teammate that the rules are told, patrolling in direction.

        The view itself: nothing is different, the robot need not go slowly.
        """
        if neighbor.distance >= _SLOW_FROM or direction is None:
            return neighbor
        ahead = neighbor.gamma * direction > 0.0
        if not (ahead and self._closes_in[direction]):
            return neighbor
        return NeighborView(float(np.interp(neighbor.distance, _IS, _TOLD)), neighbor.gamma)

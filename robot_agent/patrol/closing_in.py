"""Where robots always turn at each other, nobody drives: now and then one comes closer.

Not in the paper, whose robots turn back 1.9 m before each other and, all equally fast, meet again
at the same places: with a robot every few metres, most of all among wrecks, the gaps between stay
undriven for good. A robot that turned back from teammates at one place time after time tosses a
coin; on heads it comes on slowly, and turns back closer to the next one.
"""

from __future__ import annotations

from collections import deque

import numpy as np

from maps.border import Border

_TIMES = 3  # turns at one place, before chance is asked
_ONE_PLACE = 0.5  # m of abscissa
_AVOIDED = 1.1  # m; up to here teammates are avoided, whoever comes closer
_TURNS_AT = 1.9  # m from a teammate, by the rules
_CLOSER = 1.4  # m; there a robot at 0.2 m/s stands 1.15 m before another one that does the same
SLOWLY = 0.2  # m/s
_BRAKES_FROM = 2.4  # m


class ClosingIn:
    """Remembers where the robot turned back from teammates, on either side of it."""

    def __init__(self, border: Border, rng: np.random.Generator) -> None:
        self._border = border
        self._rng = rng
        self._places: dict[int, deque[float]] = {side: deque(maxlen=_TIMES) for side in (-1, 1)}
        self._closes_in = {-1: False, 1: False}
        self._direction = 0

    def turned(self, abscissa: float, direction: int) -> None:
        """Note that a teammate made the robot turn at an abscissa, m, into direction, +1 or -1."""
        side = -direction
        places = self._places[side]
        if places and abs(self._border.difference(places[-1], abscissa)) > _ONE_PLACE:
            places.clear()
        places.append(abscissa)
        again = len(places) == _TIMES
        self._closes_in[side] = again and bool(self._rng.random() < 0.5)

    def closes_in(self, direction: int) -> bool:
        """Tell whether the robot comes closer to a teammate ahead, patrolling in direction."""
        return self._closes_in[direction]


def judged(distance: float) -> float:
    """Return the distance from a teammate, m, that the rules are told while closing in."""
    return float(
        np.interp(distance, (_AVOIDED, _CLOSER, _BRAKES_FROM), (_AVOIDED, _TURNS_AT, _BRAKES_FROM))
    ) if distance < _BRAKES_FROM else distance


def slowed(distance: float, speed: float) -> float:
    """Return the patrol speed, m/s, so near a teammate while closing in."""
    return min(speed, SLOWLY) if distance < _BRAKES_FROM else speed

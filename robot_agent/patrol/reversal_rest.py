"""No random reversal for a while beside a teammate that stands on the border: it may be a wreck.

Not in the paper. Where a robot died, the others have its share to drive as well; chance would keep
them from it for minutes. Who sees a teammate stand on the border keeps going for some laps; then
chance has as long, so that two robots that turn at each other always at one place leave it.
"""

from __future__ import annotations

import math

_SEEN = 1.0  # s at least
_LONG_ENOUGH = 4.0  # s since it was first seen; who turns back has moved on by then
_REMEMBERED = 3.0  # s out of sight
_STILL = 0.15  # m, with the errors of sight


class ReversalRest:
    """Follows the closest teammate from its first sight until it is forgotten."""

    def __init__(self, duration: float) -> None:
        """duration: s of a rest, and at least until the next; 0: never."""
        self._duration = duration
        self._first_seen = self._last_seen = -math.inf  # s
        self._place = (math.inf, math.inf)  # where it was seen first
        self._moved = False
        self._until = -math.inf

    def rests(self, t: float, teammate: tuple[float, float] | None, gamma: float) -> bool:
        """Tell at t, s, whether reversals rest.

        teammate: (x, y) of the closest one, m in the map, if any; gamma of eq. 13: 0 away from the
        border.
        """
        if teammate is not None and gamma != 0.0:
            self._follow(t, teammate)
        stands = (
            not self._moved
            and t - self._first_seen >= _LONG_ENOUGH
            and self._last_seen - self._first_seen >= _SEEN
            and t - self._last_seen <= _REMEMBERED
        )
        if stands and t >= self._until + self._duration:
            self._until = t + self._duration
        return t < self._until

    def _follow(self, t: float, teammate: tuple[float, float]) -> None:
        if t - self._last_seen > _REMEMBERED:
            self._first_seen, self._place, self._moved = t, teammate, False
        self._moved = self._moved or math.dist(teammate, self._place) > _STILL
        self._last_seen = t

"""No random reversal for a while beside a teammate that stands on the border: it may be a wreck.

Not in the paper. Where a robot died, the others have its share to drive as well; chance would keep
them from it for minutes. Who sees a teammate stand on the border keeps going for some laps; then
chance has as long, so that two robots that turn at each other always at one place leave it.
"""

from __future__ import annotations

import math

_LONG_ENOUGH = 1.0  # s in sight; by then one that patrols has moved on by 0.35 m
_STILL = 0.15  # m, with the errors of sight


class ReversalRest:
    """Follows the closest teammate for as long as it stays in sight."""

    def __init__(self, duration: float) -> None:
        """duration: s of a rest, and at least until the next; 0: never."""
        self._duration = duration
        self._since = 0.0
        self._place: tuple[float, float] | None = None
        self._until = -math.inf

    def rests(self, t: float, teammate: tuple[float, float] | None, gamma: float) -> bool:
        """Tell at t, s, whether reversals rest.

        teammate: (x, y) of the closest one, m in the map, if any; gamma of eq. 13: 0 away from the
        border.
        """
        if teammate is None or gamma == 0.0:
            self._place = None
        elif self._place is None or math.dist(teammate, self._place) > _STILL:
            self._since, self._place = t, teammate
        stands = self._place is not None and t - self._since >= _LONG_ENOUGH
        if stands and t >= self._until + self._duration:
            self._until = t + self._duration
        return t < self._until

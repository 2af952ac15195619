"""Recovery behavior of a robot without a pose: wait, then turn in place to see more of the map."""

from __future__ import annotations

import math

_WAIT = 3.0  # s before the first turn: the pose mostly recovers by itself
_TURN_RATE = 0.4  # rad/s
_TURN = math.radians(400.0)  # rad per turn: a full circle and some overlap
_REST = 8.0  # s between turns, which alternate left and right


class RecoveryTurn:
    """Turns slowly in place, alternately left and right, until ``end`` is called."""

    def __init__(self) -> None:
        self._since: float | None = None

    def requested(self, t: float) -> tuple[float, float]:
        """Return the requested (v m/s, w rad/s) at t; the first call starts the behavior."""
        if self._since is None:
            self._since = t
        turning = _TURN / _TURN_RATE
        turns, phase = divmod(t - self._since - _WAIT, turning + _REST)
        if turns < 0.0 or phase >= turning:
            return 0.0, 0.0
        side = 1.0 if turns % 2.0 == 0.0 else -1.0
        return 0.0, side * _TURN_RATE

    def end(self) -> bool:
        """End the behavior, as the pose is known; return whether it was running."""
        was_lost, self._since = self._since is not None, None
        return was_lost

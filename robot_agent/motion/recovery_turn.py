"""What a robot does that does not know where it is: it stands, then turns to look around."""

from __future__ import annotations

import math

_WAIT = 3.0  # s to stand first: most doubts pass by themselves
_TURN_RATE = 0.4  # rad/s
_TURN = math.radians(400.0)  # rad per turn: all round, and a bit
_REST = 8.0  # s between turns, to left and right by turns


class RecoveryTurn:
    """Turns slowly, left and right by turns, for as long as the pose is not known."""

    def __init__(self) -> None:
        self._since: float | None = None

    def requested(self, t: float) -> tuple[float, float]:
        """Return the wished (v m/s, w rad/s) of a robot that is lost at ``t``, s."""
        if self._since is None:
            self._since = t
        turning = _TURN / _TURN_RATE
        turns, phase = divmod(t - self._since - _WAIT, turning + _REST)
        if turns < 0.0 or phase >= turning:
            return 0.0, 0.0
        side = 1.0 if turns % 2.0 == 0.0 else -1.0
        return 0.0, side * _TURN_RATE

    def end(self) -> bool:
        """The pose is known; return whether that is news."""
        was_lost, self._since = self._since is not None, None
        return was_lost

"""The manoeuvre out of a place where obstacles let a robot neither drive nor turn.

Pinned for a second while it turns, it turns the other way; pinned there too, and back at the
first, it edges straight ahead to where there is more room. The first side was the shorter way
round, so edging ahead there leads less astray; where no way is there either, as that side is
towards a wall, the next attempt is from the other.
"""

from __future__ import annotations

from typing import NamedTuple

EDGING_SPEED = 0.1
"""m/s; the gate lets a robot pass close to what is beside it up to little more than this."""
_PATIENCE = 1.0  # s that an obstacle pins the robot until it turns the other way
_EDGING_TIME = 1.5  # s
_PINS_BEFORE_EDGING = 3  # one side, the other, and the first again


class Unpinning(NamedTuple):
    """What the heading loop is asked to do out of its own order.

    turn_side: the side, +1 left or -1, to turn to from now on; 0 leaves it. edges: drive straight
    ahead at EDGING_SPEED in this step.
    """

    turn_side: int
    edges: bool


_NOTHING = Unpinning(0, edges=False)


class UnpinningManoeuvre:
    """Follows how an obstacle pins a robot that turns on the spot."""

    def __init__(self) -> None:
        self._pinned_since: float | None = None
        self._pins = 0  # of the present turn
        self._edges_until: float | None = None  # s, while edging ahead

    def step(
        self, t: float, *, pinned: bool, turn_rate: float, turn_side: int, aligned: bool
    ) -> Unpinning:
        """Return what to do at t, s, after a command with a turn rate, rad/s, to a side.

        pinned: an obstacle let the robot neither drive nor turn by that command. aligned: it had
        come round to its heading.
        """
        if aligned:
            self._pins = 0
        asked = 0
        if self._edges_until is not None and t >= self._edges_until:
            self._edges_until = None
            if pinned:
                asked = turn_side = -turn_side
        asked = self._next_side(t, pinned=pinned, turn_rate=turn_rate) or asked
        if not asked and self._edges_until is None:
            return _NOTHING
        return Unpinning(asked, edges=self._edges_until is not None)

    def _next_side(self, t: float, *, pinned: bool, turn_rate: float) -> int:
        """Return the side to turn to after a pin of too long, 0 for none; the third pin edges."""
        if not pinned or turn_rate == 0.0:
            self._pinned_since = None
            return 0
        if self._pinned_since is None:
            self._pinned_since = t
            return 0
        if t - self._pinned_since < _PATIENCE:
            return 0
        self._pinned_since = None
        self._pins += 1
        if self._pins < _PINS_BEFORE_EDGING:
            return -1 if turn_rate > 0.0 else 1
        self._pins = 0
        self._edges_until = t + _EDGING_TIME
        return 0

"""Escape manoeuvre for a place where obstacles permit the robot neither to drive nor to turn.

Pinned for a second at its heading, as in a door hardly wider than itself, the robot edges straight
ahead: what finds no room there are the small corrections of its heading. Pinned for a second
during a turn, it turns the other way; pinned there too, and again on the first side, it edges
straight ahead to where there is more room. The first side is the shorter turn, so edging ahead
there deviates less; if the way is blocked there, as that side faces a wall, the next attempt is
from the other side.
"""

from __future__ import annotations

from typing import NamedTuple

EDGING_SPEED = 0.1
"""m/s; up to slightly more than this the gate permits driving close past points at the side."""
TIMEOUT = 1.0  # s that an obstacle pins the robot until it turns the other way
EDGING_TIME = 1.5  # s
PINS_BEFORE_EDGING = 3  # one side, the other, and the first again


class Unpinning(NamedTuple):
    """Override of the heading loop in one step.

    turn_side: the side, +1 left or -1, to turn to from now on; 0 keeps the present one. edges:
    drive straight ahead at EDGING_SPEED in this step.
    """

    turn_side: int
    edges: bool


NO_UNPINNING = Unpinning(0, edges=False)


class Turn(NamedTuple):
    """The turn of a command: rate, rad/s; side in place, +1 left, -1 right, 0 none.

    aligned: the robot had reached its heading.
    """

    rate: float
    side: int
    aligned: bool


class UnpinningManoeuvre:
    """State of the manoeuvre: counts the pins of a turn in place and times the edging."""

    def __init__(self) -> None:
        self._pinned_since: float | None = None
        self._pins = 0  # of the present turn
        self._edges_until: float | None = None  # s, while edging ahead
        self._edges_at_heading = False  # if so: edging ends when another heading is wanted

    def step(self, t: float, last: Turn, *, pinned: bool) -> Unpinning:
        """Return the override at t; call once per control step.

        last: the turn of the last command. pinned: an obstacle permitted the robot neither to
        drive nor to turn by it.
        """
        if last.aligned:
            self._pins = 0
        side = 0
        if self._edges_until is not None and (
            t >= self._edges_until or (self._edges_at_heading and not last.aligned)
        ):
            self._edges_until = None
            if pinned:
                side = -last.side
        side = self._next_side(t, last, pinned=pinned) or side
        if not side and self._edges_until is None:
            return NO_UNPINNING
        return Unpinning(side, edges=self._edges_until is not None)

    def _next_side(self, t: float, last: Turn, *, pinned: bool) -> int:
        """Return the side to turn to after a pin for the timeout, 0 for none.

        A pin at the heading, and the third one of a turn, start edging instead.
        """
        at_heading = last.aligned and self._edges_until is None
        if not pinned or not (last.rate or at_heading):
            self._pinned_since = None
            return 0
        if self._pinned_since is None:
            self._pinned_since = t
            return 0
        if t - self._pinned_since < TIMEOUT:
            return 0
        self._pinned_since = None
        self._pins += 1
        if not last.aligned and self._pins < PINS_BEFORE_EDGING:
            return -1 if last.rate > 0.0 else 1
        self._pins = 0
        self._edges_until, self._edges_at_heading = t + EDGING_TIME, last.aligned
        return 0

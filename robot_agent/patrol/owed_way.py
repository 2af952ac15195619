"""The way ahead of a robot that turned back at random, which it owes before it may do so again.

Not in the paper, whose random variable is left open: drawn anew every time, it may keep a robot
from part of its border for as long as chance has it, most of all beside a wreck. With the debt a
robot turns back at places nobody can foretell, and yet comes round.
"""

from __future__ import annotations

from maps.border import Border

_BEYOND = 1.0  # m past the place; a robot that turns back rolls on for 0.2 m


class OwedWay:
    """Remembers where, and going which way, the robot last turned back at random."""

    def __init__(self, border: Border) -> None:
        self._border = border
        self._abscissa: float | None = None
        self._direction = 0
        self._returned = False  # went that way again

    def begin(self, abscissa: float, direction: int) -> None:
        """Note that the robot turns back at an abscissa, m, from direction, +1 or -1."""
        self._abscissa, self._direction, self._returned = abscissa, direction, False

    def is_owed(self, abscissa: float, direction: int) -> bool:
        """Tell a robot at abscissa, m, patrolling in direction, whether it still owes that way.

        Driven past the place, or sent back by somebody on the way there, it owes nothing any more.
        """
        if self._abscissa is None:
            return False
        beyond = self._direction * self._border.difference(abscissa, self._abscissa)
        sent_back = self._returned and direction != self._direction
        if beyond > _BEYOND or sent_back:
            self._abscissa = None
            return False
        self._returned = direction == self._direction
        return True

"""Whether the agent keeps up with what it is told."""

from __future__ import annotations

from robot_agent.motion.trust import CONTROL

MISSES = 3
"""Control steps in a row that were late prove an overload."""
CATCHES = 10
"""Control steps in a row that were in time end it."""


class DeadlineWatch:
    """Counts control steps that began too long after their report had arrived."""

    def __init__(self) -> None:
        self._late_in_a_row = 0
        self._in_time_in_a_row = 0
        self.missed = 0
        self.overloaded = False

    def note(self, lag: float) -> None:
        """Take one control step's ``lag``, s, from its report's arrival."""
        if lag > CONTROL.max_age:
            self.missed += 1
            self._late_in_a_row += 1
            self._in_time_in_a_row = 0
        else:
            self._late_in_a_row = 0
            self._in_time_in_a_row += 1
        if self._late_in_a_row >= MISSES:
            self.overloaded = True
        elif self._in_time_in_a_row >= CATCHES:
            self.overloaded = False

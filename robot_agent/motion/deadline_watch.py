"""Whether the agent keeps up with what it is told."""

from __future__ import annotations

from collections import deque

from robot_agent.motion.freshness_limits import CONTROL

MISSES = 3
WITHIN_S = 3.0
"""So many missed deadlines within so long are an overload, until the first of them is older."""


class DeadlineWatch:
    """Counts what was handled too long after it had happened."""

    def __init__(self) -> None:
        self._misses: deque[float] = deque(maxlen=MISSES)
        self.missed = 0

    def update(self, t: float, lag: float) -> None:
        """Take something handled at ``t``, ``lag`` after it ought to have been, s."""
        if lag > CONTROL.max_age:
            self.missed += 1
            self._misses.append(t)

    def overloaded(self, t: float) -> bool:
        """Tell whether too many deadlines were missed lately."""
        return len(self._misses) == MISSES and t - self._misses[0] < WITHIN_S

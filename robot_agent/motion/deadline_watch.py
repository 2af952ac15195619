"""Deadline monitor: whether the agent handles its events in time."""

from __future__ import annotations

from collections import deque

from robot_agent.motion.freshness_limits import CONTROL

MISSES = 3
WITHIN_S = 3.0
"""An overload is ``MISSES`` missed deadlines within ``WITHIN_S`` s; it ends when the first of them
is older."""


class DeadlineWatch:
    """Counts events handled later than the deadline; ``missed`` is the total."""

    def __init__(self) -> None:
        self._misses: deque[float] = deque(maxlen=MISSES)
        self.missed = 0

    def update(self, t: float, lag: float) -> None:
        """Process an event handled at t, with a lag, s, behind its due time."""
        if lag > CONTROL.max_age:
            self.missed += 1
            self._misses.append(t)

    def overloaded(self, t: float) -> bool:
        """Return whether there is an overload at t."""
        return len(self._misses) == MISSES and t - self._misses[0] < WITHIN_S

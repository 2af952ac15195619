"""The action in force, which lasts a minimum time whatever the supervisor would rather have."""

from __future__ import annotations

import math

from robot_agent.patrol.actions import Action

MINIMUM_DWELL = 0.5
"""s an action lasts, unless Avoid Teammate is called for."""
_EQUAL = 1e-9  # s


class ActionDwell:
    """Remembers the present action, None before the first, and since when."""

    def __init__(self, minimum_dwell: float) -> None:
        self.action: Action | None = None
        self._minimum_dwell = minimum_dwell
        self._since = 0.0

    def update(self, t: float, wanted: Action, distance_from_neighbor: float) -> Action:
        """Return the action in force at t, s: the wanted one if the present one may end."""
        if self.action is None or (
            wanted is not self.action and self._may_end(t, wanted, distance_from_neighbor)
        ):
            self.action, self._since = wanted, t
        return self.action

    def _may_end(self, t: float, wanted: Action, distance_from_neighbor: float) -> bool:
        """Tell whether the present action may end: at once if danger begins or has vanished."""
        if wanted is Action.AVOID_TEAMMATE:
            return True
        if self.action is Action.AVOID_TEAMMATE and distance_from_neighbor == math.inf:
            return True
        return t - self._since >= self._minimum_dwell - _EQUAL

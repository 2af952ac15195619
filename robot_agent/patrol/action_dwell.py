"""Minimum dwell time of the selected action."""

from __future__ import annotations

import math

from robot_agent.patrol.actions import Action

MINIMUM_DWELL = 0.5
"""s for which an action is kept, unless Avoid Teammate is selected."""
EQUAL = 1e-9  # s


class ActionDwell:
    """Holds the action in force for a minimum time; ``action`` is None before the first update."""

    def __init__(self, minimum_dwell: float) -> None:
        self.action: Action | None = None
        self._minimum_dwell = minimum_dwell
        self._since = 0.0

    def copy(self, other: ActionDwell) -> None:
        """Take over the action of another, and since when it is in force."""
        self.action, self._since = other.action, other._since

    def same_as(self, other: ActionDwell) -> bool:
        """Return whether another has the same action in force since the same time."""
        return self.action is other.action and self._since == other._since

    def update(self, t: float, wanted: Action, distance_from_neighbor: float) -> Action:
        """Return the action in force at t: ``wanted`` if the present one may end, else that.

        distance_from_neighbor: m; infinite without a neighbor.
        """
        if self.action is None or (
            wanted is not self.action and self._may_end(t, wanted, distance_from_neighbor)
        ):
            self.action, self._since = wanted, t
        return self.action

    def _may_end(self, t: float, wanted: Action, distance_from_neighbor: float) -> bool:
        """Return whether the present action may end.

        It may at once if Avoid Teammate is to begin, or if it is in force and no teammate is left.
        """
        if wanted is Action.AVOID_TEAMMATE:
            return True
        if self.action is Action.AVOID_TEAMMATE and distance_from_neighbor == math.inf:
            return True
        return t - self._since >= self._minimum_dwell - EQUAL

"""A robot caught between an end of an open border and a teammate, and its way out."""

from __future__ import annotations

import math

from robot_agent.patrol.actions import Action
from robot_agent.patrol.modifier import Override, OverrideReason
from robot_agent.patrol.situation import Situation
from robot_agent.patrol.supervisor import Choice

_OTHERS = (Action.KEEP_GOING, Action.REACH_FRONTIER, Action.AVOID_TEAMMATE)


def way_out(situation: Situation, choice: Choice) -> Action | None:
    """Return the patrol that leads away from the nearer end, of a robot caught there; else None.

    Caught: the end and a teammate call for both directions at once.
    """
    left, right = situation.ends
    if left == math.inf:
        return None
    degrees = choice.degrees
    both = min(degrees[Action.PATROL_CLOCKWISE], degrees[Action.PATROL_COUNTER_CLOCKWISE])
    if both <= max(degrees[action] for action in _OTHERS):
        return None
    return Action.PATROL_CLOCKWISE if left <= right else Action.PATROL_COUNTER_CLOCKWISE


class HoldAtEnd:
    """Stands while both directions are called for, rather than turn to and fro.

    Not in the paper, whose arbiter would take either.
    """

    def propose(
        self,
        situation: Situation,
        choice: Choice,
        action: Action,  # noqa: ARG002 - stands in whatever is in force
    ) -> Override | None:
        """Stand while caught."""
        if way_out(situation, choice) is None:
            return None
        return Override(OverrideReason.HOLD_AT_END, speed_limit=0.0)

"""A robot between an end of an open border and a teammate: detection, and ``hold_at_end``."""

from __future__ import annotations

import math

from robot_agent.patrol.actions import Action
from robot_agent.patrol.modifier import Override, OverrideReason
from robot_agent.patrol.situation import Situation
from robot_agent.patrol.supervisor import Choice

_OTHERS = (Action.KEEP_GOING, Action.REACH_FRONTIER, Action.AVOID_TEAMMATE)


def way_out(situation: Situation, choice: Choice) -> Action | None:
    """Return the patrol action that leads away from the nearer end; None unless caught there.

    Caught: end and teammate activate both patrol directions at once, above all other actions.
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
    """Modifier ``hold_at_end``: stops the robot while both directions are activated at once.

    Not in the paper, whose arbiter would select either, so that the robot would turn to and fro.
    """

    def propose(
        self,
        situation: Situation,
        choice: Choice,
        action: Action,  # noqa: ARG002 - stops whatever the action in force
    ) -> Override | None:
        """Return a stop while caught, else None."""
        if way_out(situation, choice) is None:
            return None
        return Override(OverrideReason.HOLD_AT_END, speed_limit=0.0)

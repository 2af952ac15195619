"""Robots between an end of an open border and a teammate: ``end_trap`` for many at once."""

from __future__ import annotations

import numpy as np

from robot_agent.patrol.modifier import OverrideReason
from tools.batch.arbiters import Choices
from tools.batch.arrays import Codes, Indices
from tools.batch.situations import NONE, Act, Overrides, Situations


def ways_out(at: Situations, choices: Choices) -> Codes:
    """Return (n,) the patrol action that leads away from the nearer end; NONE unless caught."""
    out = np.full(len(at.x), NONE, dtype=np.int8)
    caught = choices.both_ways.nonzero()[0]
    if not at.closed and caught.size:
        left = at.left[caught] <= at.right[caught]
        out[caught] = np.where(left, Act.PATROL_CLOCKWISE, Act.PATROL_COUNTER_CLOCKWISE)
    return out


class HoldsAtEnds:
    """Modifier ``hold_at_end``: stops robots while both directions are activated at once."""

    def pick(self, robots: Indices) -> None:
        """Keep some robots: there is no state."""

    def propose(
        self,
        at: Situations,
        choices: Choices,
        action: Codes,  # noqa: ARG002 - stops whatever the action in force
        found: Overrides,
    ) -> Indices:
        """Put a stop while caught."""
        caught = np.flatnonzero(ways_out(at, choices) != NONE)
        found.put(caught, OverrideReason.HOLD_AT_END, speed_limit=0.0)
        return caught

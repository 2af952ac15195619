"""``Situation`` and ``Override`` for many robots at once."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from robot_agent.patrol.actions import Action
from robot_agent.patrol.modifier import OverrideReason
from robot_agent.patrol.turn_log import TurnCause
from tools.batch.arrays import Codes, Flags, Indices, Reals

ACTIONS = tuple(Action)
REASONS = tuple(OverrideReason)
CAUSES = tuple(TurnCause)
NONE = -1
"""The number of no action, reason or cause."""


class Act(IntEnum):
    """Numbers of the actions, in the order of ``Action``."""

    REACH_FRONTIER = 0
    KEEP_GOING = 1
    PATROL_CLOCKWISE = 2
    PATROL_COUNTER_CLOCKWISE = 3
    AVOID_TEAMMATE = 4


SETS_DIRECTION = np.array([0, 0, 1, -1, 0], dtype=np.int8)
"""The direction that each action sets, 0 for none."""
PATROLS = np.array([False, True, True, True, False])
"""Whether the robot patrols in an action."""


@dataclass(slots=True, eq=False)
class Situations:
    """Inputs of one step of all robots; as ``Situation``, arrays (n,), m and rad, map frame."""

    t: float
    x: Reals
    y: Reals
    theta: Reals
    s: Reals  # abscissa
    foot_x: Reals
    foot_y: Reals
    distance: Reals  # from the border
    tx: Reals
    ty: Reals
    curvature: Reals
    mate: Flags  # whether a teammate is in range
    mate_x: Reals
    mate_y: Reals
    neighbor: Reals  # distance; infinite without a teammate
    gamma: Reals
    left: Reals  # distances from the ends; infinite if closed
    right: Reals
    hidden: Indices  # numbers of the robots from which a wall hides the border
    aim_x: Reals  # first direction of their paths round walls
    aim_y: Reals
    direction: Codes  # 0: none yet
    held: Flags
    way: Reals  # to the border, round walls

    @property
    def closed(self) -> bool:
        """Whether the border has no ends."""
        return bool(self.left[0] == math.inf)


@dataclass(slots=True, eq=False)
class Overrides:
    """At most one override of each robot's step, as ``Override``; arrays (n,)."""

    reason: Codes  # NONE: no override
    action: Codes
    turn: Codes
    may_turn: Flags
    speed_limit: Reals  # infinite: no limit

    @classmethod
    def of_none(cls, n: int) -> Overrides:
        """Return no override of n robots."""
        return cls(
            np.full(n, NONE, dtype=np.int8),
            np.full(n, NONE, dtype=np.int8),
            np.full(n, NONE, dtype=np.int8),
            np.ones(n, dtype=np.bool_),
            np.full(n, math.inf),
        )

    def put(
        self,
        where: Indices | int,
        reason: OverrideReason,
        *,
        action: Codes | int = NONE,
        turn: TurnCause | None = None,
        may_turn: bool = True,
        speed_limit: Reals | float = math.inf,
    ) -> None:
        """Replace the overrides of some robots."""
        self.reason[where] = REASONS.index(reason)
        self.action[where] = action
        self.turn[where] = NONE if turn is None else CAUSES.index(turn)
        self.may_turn[where] = may_turn
        self.speed_limit[where] = speed_limit

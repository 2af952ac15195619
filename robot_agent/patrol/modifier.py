"""Modifiers: what may be put in place of the paper's choice, each by one small class.

Every modifier proposes at most one override a step. They are asked from the last of the list to
the first, each told the action in force below it; the first in the list that proposes one wins.
"""

from __future__ import annotations

from enum import StrEnum
from typing import Protocol

import msgspec

from robot_agent.patrol.actions import Action
from robot_agent.patrol.situation import Situation
from robot_agent.patrol.supervisor import Choice
from robot_agent.patrol.turn_log import TurnCause


class OverrideReason(StrEnum):
    """Why a step did not go by the paper's choice alone."""

    STANDOFF = "standoff"  # kept from its way for long, it insists on it
    HOLD_AT_END = "hold_at_end"  # stands, caught between an end and a teammate
    BLOCKAGE = "blockage"  # gave up waiting for an object on its way
    WAIT = "wait"  # stands for a moment, not to turn in step with the others
    CLOSING_IN = "closing_in"  # comes on slowly past the place where it always turned
    EVEN_GAPS = "even_gaps"  # turns, or does not turn by chance, to space the team evenly


class Override(msgspec.Struct, frozen=True):
    """What takes the place of the paper's choice for one step.

    action: None leaves it. turn: a cause turns a robot that keeps going; ``may_turn`` False keeps
    the random reversal from turning it. speed_limit: of patrol, m/s; 0 stands, None leaves it.
    """

    reason: OverrideReason
    action: Action | None = None
    turn: TurnCause | None = None
    may_turn: bool = True
    speed_limit: float | None = None


class Modifier(Protocol):
    """One thing beyond the paper."""

    def propose(self, situation: Situation, choice: Choice, action: Action) -> Override | None:
        """Return an override of this step, or None.

        choice: the paper's, as it is. action: in force so far, by modifiers later in the list.
        """

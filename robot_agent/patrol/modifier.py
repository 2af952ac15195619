"""Modifiers: optional changes of the paper's choice, one small class each.

Every modifier proposes at most one override a step. They are evaluated from the last in the list
to the first, each with the action that results from those after it; the first in the list that
proposes one wins.
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
    """Why a step differs from the paper's choice."""

    STANDOFF = "standoff"  # held back for long: takes the way to the border, along it, or out
    HOLD_AT_END = "hold_at_end"  # stands, caught between an end and a teammate
    BLOCKAGE = "blockage"  # turns back after waiting for an object on its way
    WAIT = "wait"  # stands for a random time, to break the synchronization of turns
    CLOSING_IN = "closing_in"  # drives slowly past the place where it turned repeatedly
    COMMON_TURNS = "common_turns"  # turns with the team, or skips a reversal of its own
    EVEN_GAPS = "even_gaps"  # turns, or skips a random reversal, to space the team evenly


class Override(msgspec.Struct, frozen=True):
    """Replacement of parts of the paper's choice for one step.

    action: None keeps the paper's. turn: a cause turns the robot back if its action is Keep Going;
    None does not. may_turn: False suppresses the random reversal. speed_limit: of patrol, m/s; 0
    stops the robot, None sets no limit.
    """

    reason: OverrideReason
    action: Action | None = None
    turn: TurnCause | None = None
    may_turn: bool = True
    speed_limit: float | None = None


class Modifier(Protocol):
    """A change of the paper's choice beyond the paper."""

    def propose(self, situation: Situation, choice: Choice, action: Action) -> Override | None:
        """Return an override of this step, or None to change nothing.

        choice: the paper's, unchanged. action: the one that modifiers later in the list lead to.
        Called in every step, so that a modifier can keep state.
        """

"""The arbiter: selects the action with the largest degree of activation, with a minimum dwell."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

import msgspec

from robot_agent.patrol.action_dwell import ActionDwell
from robot_agent.patrol.actions import Action
from robot_agent.patrol.fuzzy import MamdaniSystem

_ACTIONS = tuple(Action)
EQUAL = 1e-9  # degrees nearer than this are tied


class Choice(msgspec.Struct, frozen=True):
    """Degrees of activation of all actions, 0 to 1, and the arbiter's result.

    raw_winner has the largest degree, runner_up the next; winner is the action selected, which
    differs from raw_winner while the one before is within its minimum dwell.
    """

    degrees: Mapping[Action, float]
    raw_winner: Action
    runner_up: Action
    winner: Action


_Ranking = tuple[dict[Action, float], Action, Action]
"""Degrees of all actions, the best one, and the one after it."""


class ActionChooser(Protocol):
    """A supervisor: chooses the action from the crisp inputs of the rule base."""

    present: ActionDwell
    """The action in force: all that a choice depends on besides the inputs."""

    def choose(self, t: float, inputs: Mapping[str, float]) -> Choice:
        """Choose the action at t from the inputs by name (``Situation.inputs``)."""


class Supervisor:
    """Fuzzy inference and arbiter; keeps the present action for a minimum dwell, s."""

    def __init__(self, system: MamdaniSystem, minimum_dwell: float) -> None:
        self._system = system
        self.present = ActionDwell(minimum_dwell)
        self._rank_inputs: tuple[Mapping[str, float], bool, Action | None] | None = None
        self._rank: _Ranking = {}, Action.KEEP_GOING, Action.KEEP_GOING

    def choose(self, t: float, inputs: Mapping[str, float]) -> Choice:
        """Choose the action at t from the crisp inputs of the rule base by name."""
        levels = self._system.evaluate(inputs)
        degrees, raw_winner, runner_up = self._ranking(levels, inputs["neighbor_state"] <= 0.0)
        winner = self.present.update(t, raw_winner, inputs["distance_from_neighbor"])
        return Choice(degrees, raw_winner, runner_up, winner)

    def _ranking(self, levels: Mapping[str, float], left: bool) -> _Ranking:
        """Return the degrees and the two best actions; cached while the degrees do not change.

        left: the neighbor, if any, is on the left.
        """
        last, present = self._rank_inputs, self.present.action
        if last is None or last[0] is not levels or last[1:] != (left, present):
            self._rank_inputs = levels, left, present
            degrees = {action: levels[action] for action in _ACTIONS}
            self._rank = degrees, *self._two_best(degrees, left)
        return self._rank

    def _two_best(self, degrees: Mapping[Action, float], left: bool) -> tuple[Action, Action]:
        """Return the two actions of highest degree.

        Of those tied with the best the present action comes first, else the safest.
        """
        best = max(degrees.values())
        safest = SAFEST_LEFT if left else SAFEST_RIGHT
        tied = [action for action in safest if degrees[action] >= best - EQUAL]
        if len(tied) == 1:
            rest = [action for action in safest if action is not tied[0]]
            return tied[0], max(rest, key=degrees.__getitem__)
        if self.present.action in tied:
            tied.sort(key=lambda action: action is not self.present.action)
        return tied[0], tied[1]


# Safest first: avoid, reach the border, patrol away from the teammate, keep going.
SAFEST_LEFT = (
    Action.AVOID_TEAMMATE,
    Action.REACH_FRONTIER,
    Action.PATROL_CLOCKWISE,
    Action.PATROL_COUNTER_CLOCKWISE,
    Action.KEEP_GOING,
)
SAFEST_RIGHT = (
    Action.AVOID_TEAMMATE,
    Action.REACH_FRONTIER,
    Action.PATROL_COUNTER_CLOCKWISE,
    Action.PATROL_CLOCKWISE,
    Action.KEEP_GOING,
)

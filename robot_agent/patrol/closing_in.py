"""Modifier ``closing_in``: vary the places at which robots turn back before each other.

Not in the paper, whose robots turn back 1.9 m before each other. At equal speeds they do so at the
same places every time, and with many robots, or with wrecks, the stretches between these places
are never patrolled. A robot that teammates have turned back repeatedly at one place stops for a
random time, which breaks the synchronization, and with some probability approaches slowly the next
time and turns back closer to the teammate: the rules are evaluated with an enlarged distance.
"""

from __future__ import annotations

import math

import numpy as np

from maps.border import Border
from robot_agent.patrol.actions import PATROL_DIRECTION, Action
from robot_agent.patrol.modifier import Override, OverrideReason
from robot_agent.patrol.neighbor_state import NeighborView
from robot_agent.patrol.situation import Situation
from robot_agent.patrol.supervisor import ActionChooser, Choice
from robot_agent.patrol.turn_log import TurnCause, TurnLog

TIMES = 3  # turns at one place that trigger the modifier
ONE_PLACE = 0.5  # m of abscissa
PROBABILITY = 0.5  # of approaching closer the next time
LONGEST_WAIT = 4.0  # s
SPEED = 0.2  # m/s
SLOW_FROM = 2.4  # m from a teammate; two robots that close in at 0.2 m/s end 1.15 m apart
CLOSEST = 1.4  # m from a teammate at which a robot that closes in turns back
# Distances, m, and those put into the rules instead, which avoid from 1.1 m and turn from 1.9 m on.
MEASURED = (0.0, 1.1, CLOSEST, SLOW_FROM)
ENLARGED = (0.0, 1.1, 1.9, SLOW_FROM)


class ClosingIn:
    """Moves the turning point closer to a teammate after three turns at one place.

    ``rules`` is evaluated with the enlarged distance. It must be a separate instance, as a chooser
    keeps state (its action).
    """

    def __init__(
        self,
        border: Border,
        paper: ActionChooser,
        rules: ActionChooser,
        turns: TurnLog,
        rng: np.random.Generator,
        probability: float = PROBABILITY,
    ) -> None:
        self._border = border
        self._paper = paper
        self._rules = rules
        self._diverged = False
        self._turns = turns
        self._rng = rng
        self._probability = probability
        self._closing_in = {-1: False, 1: False}  # by direction of patrol
        self._wait_until = -math.inf

    def propose(
        self,
        situation: Situation,
        choice: Choice,
        action: Action,  # noqa: ARG002 - replaced by the winner of the rules evaluated here
    ) -> Override | None:
        """Return a stop during the random wait, a speed limit while closing in, else None."""
        view = self._view_for_rules(situation.neighbor, situation.direction)
        winner = self._winner(situation, choice, view)
        self._on_turn(situation, winner)
        if situation.t < self._wait_until and winner is not Action.AVOID_TEAMMATE:
            return Override(OverrideReason.WAIT, winner, speed_limit=0.0)
        if view is not situation.neighbor:
            return Override(OverrideReason.CLOSING_IN, winner, speed_limit=SPEED)
        if winner is not choice.winner:  # its action is still within its minimum dwell
            return Override(OverrideReason.CLOSING_IN, winner)
        return None

    def _winner(self, situation: Situation, choice: Choice, view: NeighborView) -> Action:
        """Return the winner of the rules for a view; the paper's while theirs cannot differ."""
        if not self._diverged:
            return choice.winner
        winner = self._rules.choose(situation.t, situation.inputs(view)).winner
        if not any(self._closing_in.values()):
            self._diverged = not self._rules.present.same_as(self._paper.present)
        return winner

    def _view_for_rules(self, neighbor: NeighborView, direction: int | None) -> NeighborView:
        """Return the view of the closest teammate to put into the rules.

        It is ``neighbor`` itself (the same object) unless the robot closes in on a teammate ahead.
        """
        if neighbor.distance >= SLOW_FROM or direction is None:
            return neighbor
        ahead = neighbor.gamma * direction > 0.0
        if not (ahead and self._closing_in[direction]):
            return neighbor
        return NeighborView(float(np.interp(neighbor.distance, MEASURED, ENLARGED)), neighbor.gamma)

    def _on_turn(self, situation: Situation, winner: Action) -> None:
        """If a teammate ahead turns the robot in this step, draw whether to close in, and a wait.

        Draws only at the third such turn in a row at one place, or a later one.
        """
        direction = situation.direction
        if direction is None or PATROL_DIRECTION.get(winner) != -direction:
            return
        if situation.neighbor.gamma * direction <= 0.0:
            return
        again = self._turns_at_place(situation.foot.abscissa, -direction) >= TIMES
        self._closing_in[direction] = again and float(self._rng.random()) < self._probability
        if self._closing_in[direction] and not self._diverged:
            self._rules.present.copy(self._paper.present)
            self._diverged = True
        if again:
            self._wait_until = situation.t + float(self._rng.uniform(0.0, LONGEST_WAIT))

    def _turns_at_place(self, abscissa: float, to: int) -> int:
        """Return the number of turns in a row to a direction caused by teammates near an abscissa.

        abscissa: m. The turn of this step, not in the log yet, counts; the result is at most the
        number that triggers the modifier.
        """
        times = 1
        for turn in self._turns.latest_first(TurnCause.TEAMMATE, to):
            if abs(self._border.difference(turn.abscissa, abscissa)) > ONE_PLACE:
                break
            times, abscissa = times + 1, turn.abscissa
            if times == TIMES:
                break
        return times

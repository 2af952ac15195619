"""Where robots always turn at each other nobody drives: now and then one comes closer there.

Not in the paper, whose robots turn back 1.9 m before each other and, equally fast, do so at the
same places again: among many, most of all among wrecks, the gaps between stay undriven for good.
A robot that teammates sent back at one place time after time stands for a moment, as chance has
it, so that they no longer turn in step, and tosses a coin. On heads it comes on slowly next time,
and turns closer to them: the rules are asked with a larger distance than there is.
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

_TIMES = 3  # turns at one place before chance is asked
_ONE_PLACE = 0.5  # m of abscissa
_PROBABILITY = 0.5  # of coming closer the next time
_LONGEST_WAIT = 4.0  # s
_SPEED = 0.2  # m/s
_SLOW_FROM = 2.4  # m from a teammate; two that close in at 0.2 m/s stand 1.15 m apart in the end
CLOSEST = 1.4  # m from a teammate, where one that closes in turns
# Distances, m, and what the rules are told instead. They avoid from 1.1 m and turn from 1.9 m on.
_IS = (0.0, 1.1, CLOSEST, _SLOW_FROM)
_TOLD = (0.0, 1.1, 1.9, _SLOW_FROM)


class ClosingIn:
    """Lets a robot turn closer to teammates that sent it back thrice at one place.

    The rules are asked a second time, with the distance changed; ``rules`` must be a chooser of
    its own, as it remembers its action.
    """

    def __init__(
        self,
        border: Border,
        rules: ActionChooser,
        turns: TurnLog,
        rng: np.random.Generator,
        probability: float = _PROBABILITY,
    ) -> None:
        self._border = border
        self._rules = rules
        self._turns = turns
        self._rng = rng
        self._probability = probability
        self._closes_in = {-1: False, 1: False}  # by direction of patrol
        self._waits_until = -math.inf  # s

    def propose(
        self,
        situation: Situation,
        choice: Choice,
        action: Action,  # noqa: ARG002 - the rules as told decide
    ) -> Override | None:
        """Stand for a moment after such a turn; come on slowly the next time."""
        told = self._told(situation.neighbor, situation.direction)
        winner = self._rules.choose(situation.t, situation.inputs(told)).winner
        self._notice_turn(situation, winner)
        if situation.t < self._waits_until and winner is not Action.AVOID_TEAMMATE:
            return Override(OverrideReason.WAIT, winner, speed_limit=0.0)
        if told is not situation.neighbor:
            return Override(OverrideReason.CLOSING_IN, winner, speed_limit=_SPEED)
        if winner is not choice.winner:  # an action lasts its minimum time
            return Override(OverrideReason.CLOSING_IN, winner)
        return None

    def _told(self, neighbor: NeighborView, direction: int | None) -> NeighborView:
        """Return the view of the closest teammate to ask the rules with; itself if unchanged."""
        if neighbor.distance >= _SLOW_FROM or direction is None:
            return neighbor
        ahead = neighbor.gamma * direction > 0.0
        if not (ahead and self._closes_in[direction]):
            return neighbor
        return NeighborView(float(np.interp(neighbor.distance, _IS, _TOLD)), neighbor.gamma)

    def _notice_turn(self, situation: Situation, winner: Action) -> None:
        """Ask chance when a teammate ahead turns the robot in this step, where it often did."""
        direction = situation.direction
        if direction is None or PATROL_DIRECTION.get(winner) != -direction:
            return
        if situation.neighbor.gamma * direction <= 0.0:
            return
        again = self._times_sent_back(situation.foot.abscissa, -direction) >= _TIMES
        self._closes_in[direction] = again and float(self._rng.random()) < self._probability
        if again:
            self._waits_until = situation.t + float(self._rng.uniform(0.0, _LONGEST_WAIT))

    def _times_sent_back(self, abscissa: float, to: int) -> int:
        """Return how often in a row, with now, teammates turned it to a direction hereabouts."""
        times = 1
        for turn in self._turns.latest_first(TurnCause.TEAMMATE, to):
            if abs(self._border.difference(turn.abscissa, abscissa)) > _ONE_PLACE:
                break
            times, abscissa = times + 1, turn.abscissa
            if times == _TIMES:
                break
        return times

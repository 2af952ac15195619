"""``BlockedWay`` for many robots at once."""

from __future__ import annotations

import math

import numpy as np

from robot_agent.patrol import blocked_way
from robot_agent.patrol.behaviors import COUNTER_CLOCKWISE
from robot_agent.patrol.turn_log import TurnCause
from tools.batch.arrays import Indices, pick
from tools.batch.border_feet import BorderFeet
from tools.batch.held_places import HeldPlaces
from tools.batch.situations import Situations
from tools.batch.turn_logs import TurnLogs


class BlockedWays:
    """Remembers where standing teammates turned each robot back, by its new direction."""

    def __init__(self, feet: BorderFeet, turns: TurnLogs) -> None:
        n = len(turns)
        self._feet = feet
        self._turns = turns
        self._stands = HeldPlaces(n, blocked_way.STANDS_RADIUS, blocked_way.LOST_S)
        self._stood = np.zeros(n)
        self._seen = np.zeros(n, dtype=np.intp)  # turns
        self._before = np.full((2, n), math.nan)  # clockwise, counter-clockwise

    def found(self, at: Situations) -> Indices:
        """Return the robots whose turn in the last step shows that the way is blocked."""
        found = [
            robot
            for robot in (self._turns.times > self._seen).nonzero()[0].tolist()
            if self._is_again(robot)
        ]
        self._seen = self._turns.times.copy()
        seen = at.mate.nonzero()[0]
        self._stood = np.zeros(len(self._stood))
        if seen.size:
            self._stood[seen] = self._stands.update(seen, at.t, at.mate_x, at.mate_y)
        return np.array(found, dtype=np.intp)

    def pick(self, robots: Indices) -> None:
        """Keep some robots, as ``arrays.pick`` does."""
        pick(self, ("_stood", "_seen", "_before"), robots)
        self._stands.pick(robots)

    def _is_again(self, robot: int) -> bool:
        turn = self._turns[robot].latest
        assert turn is not None
        if turn.cause is not TurnCause.TEAMMATE or self._stood[robot] < blocked_way.STANDS_S:
            return False
        side = int(turn.direction == COUNTER_CLOCKWISE)
        before, self._before[side, robot] = self._before[side, robot], turn.abscissa
        apart = self._feet.difference(np.array([turn.abscissa]), np.array([before]))
        return bool(abs(apart[0]) <= blocked_way.ONE_PLACE)  # nan, before the first: False

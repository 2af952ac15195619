"""Turns that evenly spaced robots make together, drawn from a secret that they share.

Robots that circle a closed border evenly spaced and turn at the same moments stay evenly spaced:
the team is one robot on a circle of one gap. Agmon, Kaminka and Kraus ("Multi-robot adversarial
patrolling: facing a full-knowledge opponent", 2011) let it turn at random. Here a turn is made only
if afterwards every place can still be visited in time: straight on, or straight on until a later
tick and then back. So the longest time without a visit has a limit, and who knows everything but
the secret still cannot tell what comes.
"""

from __future__ import annotations

import copy
import math

import numpy as np

TICK_S = 4.0
"""s between two moments at which the team may turn; ours."""
TURN_S = 5.5
"""s that a turn takes away from the patrol at 0.35 m/s: braking, half a turn, getting faster."""
_PLACES = 64  # in one gap
_FARTHEST = 20  # ticks ahead at which a turn back is considered


class CommonSchedule:
    """The turns of a team, tick by tick; all robots that make it the same have the same turns.

    At its begin all drive one way and have done so for at least one gap.
    """

    def __init__(
        self, rng: np.random.Generator, gap_s: float, limit_s: float, probability: float
    ) -> None:
        """gap_s: s from one robot to the next. limit_s: longest time without a visit, s, that the
        turns may lead to; hardly anybody turns if it is below two gaps. probability: of
        wanting to turn at a tick.
        """
        self._rng = rng
        self._gap = gap_s
        self._limit = limit_s
        self._probability = probability
        self._places = np.arange(_PLACES) / _PLACES * gap_s  # s of driving from the first
        self._visited = self._places - gap_s  # s; the place at 0 is visited now
        self._visited[0] = 0.0
        self._phase = 0.0
        self._direction = 1
        self._turning = 0.0  # s still to turn
        self._made: list[bool] = []
        ticks = np.arange(1, _FARTHEST + 1)[:, None] * TICK_S
        self._until = np.concatenate((ticks, [[math.inf]]))

    def turns_at(self, tick: int) -> bool:
        """Return whether the team turns at a tick, from 0; ticks may be asked for in any order."""
        while len(self._made) <= tick:
            self._made.append(self._decide())
            self._advance()
        return self._made[tick]

    def going_on(self, rng: np.random.Generator) -> CommonSchedule:
        """Return a schedule with the same turns so far, and others from now on."""
        other = copy.copy(self)
        other._rng, other._made = rng, list(self._made)
        other._visited = self._visited.copy()
        return other

    def _decide(self) -> bool:
        wants = float(self._rng.random()) < self._probability
        if self._turning > 0.0 or not self._made:
            return False
        stays, turns = self._in_time(self._direction, 0.0), self._in_time(-self._direction, TURN_S)
        return turns and (wants or not stays)

    def _in_time(self, direction: int, delay: float) -> bool:
        """Return whether some way to go on in a direction visits every place within the limit.

        delay: s until the robots drive in that direction.
        """
        now = len(self._made) * TICK_S
        ahead = (self._places - self._phase) * direction % self._gap
        turn_after = self._until - delay  # s of driving before the turn back
        back = delay + 2.0 * turn_after + TURN_S + (self._gap - ahead)
        arrival = np.where(ahead <= turn_after, delay + ahead, back)
        arrival[turn_after[:, 0] < 0.0] = math.inf  # nobody turns before a turn is done
        return bool((now - self._visited + arrival <= self._limit).all(axis=1).any())

    def _advance(self) -> None:
        """Follow the team to the next tick."""
        now = (len(self._made) - 1) * TICK_S
        if self._made[-1]:
            self._direction, self._turning = -self._direction, TURN_S
        stands = min(self._turning, TICK_S)
        drives = TICK_S - stands
        self._turning -= stands
        ahead = (self._places - self._phase) * self._direction % self._gap
        passed = ahead <= drives
        self._visited[passed] = now + stands + ahead[passed]
        self._phase = (self._phase + self._direction * drives) % self._gap

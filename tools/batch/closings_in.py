"""Modifier ``closing_in`` for many robots at once."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from maps.border import Border
from robot_agent.patrol import closing_in
from robot_agent.patrol.modifier import OverrideReason
from robot_agent.patrol.turn_log import TurnCause, TurnLog
from tools.batch.arbiters import Arbiters, Choices
from tools.batch.arrays import Codes, Flags, Indices, pick
from tools.batch.situations import SETS_DIRECTION, Act, Overrides, Situations


class ClosingsIn:
    """Moves turning points closer to teammates after three turns at one place."""

    def __init__(
        self,
        border: Border,
        paper: Arbiters,
        rules: Arbiters,
        turns: Sequence[TurnLog],
        rngs: Sequence[np.random.Generator],
    ) -> None:
        """rules: evaluated with the enlarged distance, separate from those of the paper."""
        n = len(turns)
        self._border = border
        self._paper = paper
        self._rules = rules
        self._turns = turns
        self._rngs = rngs
        self._diverged = np.zeros(n, dtype=np.bool_)
        self._closing_in = np.zeros((2, n), dtype=np.bool_)  # clockwise, counter-clockwise
        self._wait_until = np.full(n, -math.inf)

    def propose(
        self,
        at: Situations,
        choices: Choices,
        action: Codes,  # noqa: ARG002 - replaced by the winner of the rules evaluated here
        found: Overrides,
    ) -> Indices:
        """Put stops during random waits, and speed limits while closing in."""
        ahead = (at.gamma * at.direction > 0.0) & (at.neighbor < np.inf)
        closes = np.where(at.direction > 0, self._closing_in[0], self._closing_in[1])
        closes &= ahead & (at.neighbor < closing_in.SLOW_FROM)
        winner = self._winner(at, choices, closes)
        self._on_turn(at, winner, ahead)
        waits = (at.t < self._wait_until) & (winner != Act.AVOID_TEAMMATE)
        changed = np.flatnonzero(waits | closes | (winner != choices.winner))
        if changed.size:
            own = winner[changed]
            limit = np.where(closes[changed], closing_in.SPEED, math.inf)
            found.put(changed, OverrideReason.CLOSING_IN, action=own, speed_limit=limit)
            standing = waits.nonzero()[0]
            found.put(standing, OverrideReason.WAIT, action=winner[standing], speed_limit=0.0)
        return changed

    def pick(self, robots: Indices) -> None:
        """Keep some robots, as ``arrays.pick`` does."""
        pick(self, ("_diverged", "_closing_in", "_wait_until"), robots)
        self._rules.pick(robots)

    def _winner(self, at: Situations, choices: Choices, closes: Flags) -> Codes:
        some = self._diverged.nonzero()[0]
        if not some.size:
            return choices.winner
        winner = choices.winner.copy()
        neighbor = at.neighbor[some]
        moved = closes[some]
        neighbor[moved] = np.interp(neighbor[moved], closing_in.MEASURED, closing_in.ENLARGED)
        winner[some] = self._rules.choose_some(at, choices, some, moved, neighbor)
        done = some[~self._closing_in[:, some].any(axis=0)]
        self._diverged[done] = (self._rules.action[done] != self._paper.action[done]) | (
            self._rules.since[done] != self._paper.since[done]
        )
        return winner

    def _on_turn(self, at: Situations, winner: Codes, ahead: Flags) -> None:
        """Where a teammate ahead turns a robot in this step, draw as ``ClosingIn`` does."""
        to = SETS_DIRECTION[winner]
        turning = ahead & (to == -at.direction) & (to != 0)
        for index in turning.nonzero()[0].tolist():
            direction = -int(to[index])
            log, rng = self._turns[index], self._rngs[index]
            again = self._turns_at_place(log, float(at.s[index]), -direction)
            way = 0 if direction > 0 else 1
            closes = again and float(rng.random()) < closing_in.PROBABILITY
            self._closing_in[way, index] = closes
            if closes and not self._diverged[index]:
                self._rules.action[index] = self._paper.action[index]
                self._rules.since[index] = self._paper.since[index]
                self._diverged[index] = True
            if again:
                wait = float(rng.uniform(0.0, closing_in.LONGEST_WAIT))
                self._wait_until[index] = at.t + wait

    def _turns_at_place(self, turns: TurnLog, abscissa: float, to: int) -> bool:
        """Whether teammates have turned a robot repeatedly near an abscissa, with this turn."""
        times = 1
        for turn in turns.latest_first(TurnCause.TEAMMATE, to):
            off = abs(self._border.difference(turn.abscissa, abscissa))
            if off > closing_in.ONE_PLACE or times == closing_in.TIMES:
                break
            times, abscissa = times + 1, turn.abscissa
        return times >= closing_in.TIMES

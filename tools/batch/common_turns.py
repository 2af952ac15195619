"""Modifier ``common_turns`` for many robots at once."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from robot_agent.patrol.common_clock import CommonClock
from robot_agent.patrol.common_schedule import TICK_S, CommonSchedule
from robot_agent.patrol.common_turns import (
    JOIN_WITHIN_S,
    LEAST_GAP_S,
    PERIOD_S,
    schedule_of,
    secret_rng,
)
from robot_agent.patrol.modifier import OverrideReason
from robot_agent.patrol.settings import PatrolSettings
from robot_agent.patrol.turn_log import TurnCause
from tools.batch.arbiters import Choices
from tools.batch.arrays import Codes, Flags, Indices, pick
from tools.batch.even_gaps import EvenGapsOfMany
from tools.batch.situations import PATROLS, Overrides, Situations
from tools.batch.turn_logs import TurnLogs

_STATE = ("_in_step", "_begun", "_tick", "_times", "_starts", "_rates")


class CommonTurnsOfMany:
    """Turns robots that are in step with their teams; else forbids turns by their own chance."""

    def __init__(
        self,
        even: EvenGapsOfMany,
        length: float,
        settings: PatrolSettings,
        turns: TurnLogs,
        clocks: Sequence[CommonClock],
        secrets: Sequence[str],
    ) -> None:
        """length: of the border, m. clocks, secrets: of the robots."""
        n = len(clocks)
        self._even = even
        even.by_chance[:] = False
        self._lap = length / settings.patrol_speed
        self._settings = settings
        self._turns = turns
        self._starts = np.array([clock.start for clock in clocks])
        self._rates = np.array([clock.at(1.0) - clock.at(0.0) for clock in clocks])
        self._in_step = np.zeros(n, dtype=np.bool_)
        self._begun = np.zeros(n)
        self._tick, self._times = np.zeros((2, n), dtype=np.intp)
        self._schedules: list[CommonSchedule | None] = [None] * n
        self._secrets = list(secrets)
        self._known: dict[tuple[str, int, int], CommonSchedule] = {}

    def propose(
        self,
        at: Situations,
        choices: Choices,  # noqa: ARG002 - only the action in force matters
        action: Codes,
        found: Overrides,
    ) -> Indices:
        """Put common turns, and no turn by chance, of robots in step."""
        now = self._starts + at.t * self._rates
        for robot in np.flatnonzero(self._disturbed(action)).tolist():
            self._in_step[robot] = False
            self._schedules[robot] = None
            self._even.resume(robot, at.t)
        counted = PATROLS[action] & (at.direction != 0) & (self._even.team != 0)
        too_many = self._lap / np.maximum(self._even.team, 1) < LEAST_GAP_S
        self._even.by_chance[counted] = too_many[counted]
        settled = self._even.are_settled(at.t) & ~too_many
        joins = counted & ~self._in_step & settled & (now % PERIOD_S <= JOIN_WITHIN_S)
        period = np.floor(now / PERIOD_S).astype(np.intp)
        for robot in joins.nonzero()[0].tolist():
            self._join(robot, int(period[robot]))
        some = np.flatnonzero(counted & self._in_step)
        found.put(some, OverrideReason.COMMON_TURNS, may_turn=False)
        turning = [
            robot
            for robot in some.tolist()
            if self._is_due(robot, math.floor((now[robot] - self._begun[robot]) / TICK_S))
        ]
        turns = np.array(turning, dtype=np.intp)
        found.put(turns, OverrideReason.COMMON_TURNS, turn=TurnCause.COMMON)
        return some

    def pick(self, robots: Indices) -> None:
        """Keep some robots, as ``arrays.pick`` does."""
        pick(self, _STATE, robots)
        self._schedules = [self._schedules[robot] for robot in robots.tolist()]
        self._secrets = [self._secrets[robot] for robot in robots.tolist()]

    def draw_anew(self, seed: int, team: int) -> None:
        """Give each run of ``team`` robots a secret of its own from now on."""
        self._known = {}
        for run in range(0, len(self._schedules), team):
            replaced: dict[int, CommonSchedule] = {}
            for robot in range(run, run + team):
                self._secrets[robot] = f"{seed}/{run}"
                schedule = self._schedules[robot]
                if schedule is None:
                    continue
                if id(schedule) not in replaced:
                    rng = np.random.default_rng((seed, run))
                    replaced[id(schedule)] = schedule.going_on(rng)
                self._schedules[robot] = replaced[id(schedule)]

    def _join(self, robot: int, period: int) -> None:
        team = int(self._even.team[robot])
        key = self._secrets[robot], period, team
        schedule = self._known.get(key)
        if schedule is None:
            schedule = schedule_of(secret_rng(*key), self._lap / team, self._settings)
            self._known[key] = schedule
        self._schedules[robot] = schedule
        self._in_step[robot] = True
        self._begun[robot], self._tick[robot] = period * PERIOD_S, 0
        self._times[robot] = self._turns.times[robot]
        self._even.suspended[robot] = True

    def _is_due(self, robot: int, tick: int) -> bool:
        schedule = self._schedules[robot]
        assert schedule is not None
        due = tick > self._tick[robot] and schedule.turns_at(tick)
        self._tick[robot] = tick
        return bool(due)

    def _disturbed(self, action: Codes) -> Flags:
        """Return which robots turned otherwise than by their schedules, or cannot patrol."""
        disturbed = self._in_step & ~PATROLS[action]
        turned = self._in_step & (self._turns.times != self._times)
        for robot in turned.nonzero()[0].tolist():
            turn = self._turns[robot].latest
            assert turn is not None
            disturbed[robot] |= turn.cause is not TurnCause.COMMON
        self._times[self._in_step] = self._turns.times[self._in_step]
        return np.asarray(disturbed)

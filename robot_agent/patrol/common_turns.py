"""Modifier ``common_turns``: evenly spaced robots turn at the same moments, from a shared secret.

Beyond the paper, and without a message: all robots know the secret and the time beforehand. Robots
that ``even_gaps`` has spaced evenly begin together at every full period of the common clock and
follow ``CommonSchedule`` from then on. A robot that meets another one meanwhile, or cannot patrol,
knows that the team is not in step: it leaves the schedule, and ``even_gaps`` spaces it again until
the next period. So a late robot, a wrong clock, a wrong count or a wreck cost what even gaps cost
without it. Without a clock that was set nothing of this happens.
"""

from __future__ import annotations

import hashlib
import math

import numpy as np

from maps.border import Border
from robot_agent.patrol.actions import PATROLLING, Action
from robot_agent.patrol.common_clock import CommonClock
from robot_agent.patrol.common_schedule import TICK_S, TURN_S, CommonSchedule
from robot_agent.patrol.even_gaps import EvenGaps
from robot_agent.patrol.modifier import Override, OverrideReason
from robot_agent.patrol.settings import PatrolSettings
from robot_agent.patrol.situation import Situation
from robot_agent.patrol.supervisor import Choice
from robot_agent.patrol.turn_log import Turn, TurnCause, TurnLog

PERIOD_S = 600.0
"""s of common time between two moments at which robots may join; ours."""
JOIN_WITHIN_S = 1.0
"""s after such a moment within which a robot joins."""
GAPS_OF_LIMIT = 2.1
"""The longest time without a visit, in even gaps, unless the settings name one: ours. Below two
gaps hardly a turn is possible."""
LEAST_GAP_S = 4.0 * TURN_S  # nearer robots are in each other's sight when they turn
_TURN = Override(OverrideReason.COMMON_TURNS, turn=TurnCause.COMMON)
_STAY = Override(OverrideReason.COMMON_TURNS, may_turn=False)


class CommonTurns:
    """Turns a robot that is in step with its team.

    Else it only forbids turns by its own chance, unless the team is too large to turn together.
    """

    def __init__(
        self,
        even: EvenGaps,
        border: Border,
        settings: PatrolSettings,
        turns: TurnLog,
        clock: CommonClock,
    ) -> None:
        """even: spaces the robots; it must be evaluated before this one."""
        self._even = even
        even.by_chance = False  # until the team is counted
        self._border = border
        self._settings = settings
        self._turns = turns
        self._clock = clock
        self._schedule: CommonSchedule | None = None
        self._begun = 0.0  # common time, s, of the schedule
        self._tick = 0
        self._latest: Turn | None = None

    def propose(
        self,
        situation: Situation,
        choice: Choice,  # noqa: ARG002 - only the action in force matters
        action: Action,
    ) -> Override | None:
        """Return a common turn, or no turn by chance; None while the robot is not in step."""
        now = self._clock.at(situation.t)
        self._leave_if_disturbed(situation, action)
        if action not in PATROLLING or situation.direction is None or self._even.team is None:
            return None
        self._even.by_chance = self._gap() < LEAST_GAP_S  # too many robots to turn together
        if self._schedule is None:
            if now % PERIOD_S > JOIN_WITHIN_S or not self._may_join(situation.t):
                return None
            self._schedule = self._join(math.floor(now / PERIOD_S))
        tick = math.floor((now - self._begun) / TICK_S)
        due = tick > self._tick and self._schedule.turns_at(tick)
        self._tick = tick
        return _TURN if due else _STAY

    def _may_join(self, t: float) -> bool:
        return self._even.is_settled(t) and self._gap() >= LEAST_GAP_S

    def _gap(self) -> float:
        """Return the even gap, s."""
        assert self._even.team is not None
        return self._border.length / self._even.team / self._settings.patrol_speed

    def _join(self, period: int) -> CommonSchedule:
        assert self._even.team is not None
        self._begun, self._tick = period * PERIOD_S, 0
        self._latest = self._turns.latest
        self._even.suspended = True
        rng = secret_rng(self._settings.common_secret, period, self._even.team)
        return schedule_of(rng, self._gap(), self._settings)

    def _leave_if_disturbed(self, situation: Situation, action: Action) -> None:
        """Leave the schedule after a turn that is not of it, or if the robot cannot patrol."""
        if self._schedule is None:
            return
        turn = self._turns.latest
        own = turn is self._latest or (turn is not None and turn.cause is TurnCause.COMMON)
        self._latest = turn
        if not own or action not in PATROLLING:
            self._schedule = None
            self._even.resume(situation.t)


def secret_rng(secret: str, period: int, team: int) -> np.random.Generator:
    """Return the generator of the turns from a period on, the same on all robots of a team."""
    digest = hashlib.sha256(f"{secret}/{period}/{team}".encode()).digest()
    return np.random.default_rng(int.from_bytes(digest[:16], "big"))


def schedule_of(rng: np.random.Generator, gap_s: float, settings: PatrolSettings) -> CommonSchedule:
    """Return the turns of a team; gap_s: s from one robot to the next."""
    limit = settings.longest_idleness or GAPS_OF_LIMIT * gap_s
    ticks = settings.reversal_period / TICK_S
    probability = 1.0 - (1.0 - settings.reversal_probability) ** (1.0 / ticks)
    return CommonSchedule(rng, gap_s, limit, probability)

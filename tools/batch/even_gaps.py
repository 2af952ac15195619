"""Modifier ``even_gaps`` for many robots at once."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from robot_agent.patrol import even_gaps
from robot_agent.patrol.behaviors import CLOCKWISE, COUNTER_CLOCKWISE
from robot_agent.patrol.modifier import OverrideReason
from robot_agent.patrol.settings import PatrolSettings
from robot_agent.patrol.turn_log import Turn, TurnCause
from tools.batch.arbiters import Choices
from tools.batch.arrays import Codes, Flags, Indices, Reals, pick
from tools.batch.blocked_ways import BlockedWays
from tools.batch.border_feet import BorderFeet
from tools.batch.situations import PATROLS, Act, Overrides, Situations
from tools.batch.turn_logs import TurnLogs

_UNKNOWN = 0  # robots in the team, while counting
_STATE = (
    "_counting_laps",
    "_begun",
    "_t",
    "_abscissa",
    "_direction",
    "_legs",
    "_leg_begun",
    "_sent_back",
    "_own_leg",
    "by_chance",
    "suspended",
    "_ahead",
    "_gained",
    "_in_vain",
    "_blocked",
    "_counting",
    "_searches",
    "team",
    "_given",
    "_probes",
    "_since",
    "_check_at",
    "_probe_at",
    "_progress",
    "_time",
    "_met",
)


class EvenGapsOfMany:
    """Turns robots that keep going so that the gaps of their team become even."""

    def __init__(
        self,
        feet: BorderFeet,
        settings: PatrolSettings,
        turns: TurnLogs,
        rngs: Sequence[np.random.Generator],
    ) -> None:
        """The border must be closed."""
        speed = settings.patrol_speed
        n = len(rngs)
        self._feet = feet
        self._lap = feet.length / speed
        self._closing_speed = 2.0 * speed
        self._turns = turns
        self._rngs = rngs
        self._counting_laps = np.full(n, even_gaps.COUNTING_LAPS)
        self._begun = np.full(n, math.nan)  # nan: no step yet
        self._t = np.zeros(n)
        self._abscissa = np.zeros(n)
        self._direction = np.full(n, CLOCKWISE, dtype=np.int8)
        self._legs = np.zeros(n, dtype=np.intp)  # number of turns processed
        self._leg_begun = np.full(n, -math.inf)  # -inf: no turn yet
        self._sent_back = np.zeros(n, dtype=np.bool_)
        self._own_leg = np.ones(n, dtype=np.bool_)  # begun by the robot itself, or no leg yet
        self._ahead = np.full(n, math.nan)
        self._gained = np.full(n, math.nan)
        self._in_vain = np.zeros(n, dtype=np.bool_)
        self._way = BlockedWays(feet, turns)
        self._blocked, self._counting = np.zeros((2, n), dtype=np.bool_)
        self._searches = np.zeros(n, dtype=np.intp)
        self.by_chance = np.ones(n, dtype=np.bool_)
        self.suspended = np.zeros(n, dtype=np.bool_)
        self._given = np.full(n, settings.team_size)  # robots, _UNKNOWN: to be counted
        self.team = np.zeros(n, dtype=np.intp)
        self._probes = np.zeros(n, dtype=np.intp)
        self._since, self._check_at, self._probe_at = np.zeros((3, n))
        self._progress = np.zeros(n)
        self._time = np.zeros((2, n))  # clockwise, counter-clockwise
        self._met = np.zeros((2, n), dtype=np.intp)
        for robot in range(n):
            self._start_counting(robot, 0.0)

    def propose(
        self,
        at: Situations,
        choices: Choices,  # noqa: ARG002 - only the action in force matters
        action: Codes,
        found: Overrides,
    ) -> Indices:
        """Put turns for even gaps; else, of robots that rest, no random reversal."""
        for robot in self._way.found(at).tolist():
            self._count_again(robot, at.t)
            self._blocked[robot] = True
        some = np.flatnonzero((at.direction != 0) & PATROLS[action])
        if not some.size:
            return some
        if self.suspended.any():
            self._hold(some[self.suspended[some]], at)
            some = some[~self.suspended[some]]
        keeps = action[some] == Act.KEEP_GOING
        turns = self._turn_back(some, at.t, at.s, at.direction, keeps)
        no_chance = self._rest(some, at)
        found.put(some[no_chance], OverrideReason.EVEN_GAPS, may_turn=False)
        found.put(some[turns], OverrideReason.EVEN_GAPS, turn=TurnCause.EVEN_GAPS)
        return np.asarray(some[turns | no_chance])

    def _rest(self, some: Indices, at: Situations) -> Flags:
        """Return for which of some robots there is to be no random reversal."""
        turned = at.t - self._leg_begun[some] < even_gaps.REST_LAPS * self._lap
        never = (at.direction[some] != CLOCKWISE) | ~self.by_chance[some]
        counted = self.team[some] != _UNKNOWN
        return np.asarray(np.where(counted, turned | never, turned & self._blocked[some]))

    def pick(self, robots: Indices) -> None:
        """Keep some robots, as ``arrays.pick`` does."""
        pick(self, _STATE, robots)
        self._way.pick(robots)

    def _turn_back(
        self, some: Indices, t: float, s: Reals, direction: Codes, keeps: Flags
    ) -> Flags:
        for robot in some[np.isnan(self._begun[some])].tolist():
            self._begin(robot, t, float(s[robot]), int(direction[robot]))
        for robot in some[self._turns.times[some] > self._legs[some]].tolist():
            self._process_turn(robot)
        self._accumulate(some, t, s)
        counted = self.team[some] != _UNKNOWN
        self._count_teams(some[~counted], t)
        self._check(some[counted], t)
        return self._should_turn(some, t, keeps)

    def resume(self, robot: int, t: float) -> None:
        """End a robot's suspension at t, as ``EvenGaps.resume`` does."""
        self.suspended[robot] = False
        self._schedule_probe(robot, t)
        self._ahead[robot], self._probes[robot] = math.nan, self.team[robot]

    def are_settled(self, t: float) -> Flags:
        """Return (n,) which robots ``EvenGaps.is_settled`` says are."""
        # nan, before the first step, compares as False.
        lasts = t - np.maximum(self._leg_begun, self._begun) >= even_gaps.SETTLED_LAPS * self._lap
        return np.asarray((self.team != _UNKNOWN) & (self._direction == CLOCKWISE) & lasts)

    def _are_even(self, some: Indices) -> Flags:
        """Return whether the gaps ahead of some robots were measured and are even."""
        even = self._feet.length / np.maximum(self.team[some], 1)
        # nan, for a gap ahead that is not known, compares as False.
        close = np.abs(self._ahead[some] - even) <= even_gaps.TOLERANCE * even
        return np.asarray(close & (self.team[some] != _UNKNOWN))

    def _hold(self, some: Indices, at: Situations) -> None:
        """Take what happens during the suspension of some robots for no observation."""
        self._t[some], self._abscissa[some] = at.t, at.s[some]
        self._direction[some] = at.direction[some]
        for robot in some[self._turns.times[some] > self._legs[some]].tolist():
            turn = self._turns[robot].latest
            assert turn is not None
            self._legs[robot], self._leg_begun[robot] = self._turns.times[robot], turn.t
            self._own_leg[robot] = turn.cause in even_gaps.OWN_CAUSES
        back = at.direction[some] == COUNTER_CLOCKWISE
        self._sent_back[some] = back & ~self._own_leg[some]
        self._gained[some], self._in_vain[some] = math.nan, False
        self._progress[some] = 0.0
        self._check_at[some] = at.t + even_gaps.CHECK_LAPS * self._lap

    # ---- observations -------------------------------------------------------------------------

    def _begin(self, robot: int, t: float, s: float, direction: int) -> None:
        self._t[robot], self._abscissa[robot], self._begun[robot] = t, s, t
        self._direction[robot], self._legs[robot] = direction, self._turns.times[robot]
        leg = self._turns[robot].latest
        if leg is not None:
            self._leg_begun[robot] = leg.t
            own = leg.cause in even_gaps.OWN_CAUSES
            self._own_leg[robot] = own
            self._sent_back[robot] = direction == COUNTER_CLOCKWISE and not own
        self._start_counting(robot, t)

    def _process_turn(self, robot: int) -> None:
        turn = self._turns[robot].latest
        assert turn is not None
        own = turn.cause in even_gaps.OWN_CAUSES
        if not own:
            self._searches[robot] = 0
            if self._counting[robot]:
                self._met[_side(self._direction[robot]), robot] += 1
            else:
                self._count_from(robot, turn.t)
                self._counting[robot] = True
        sent_back = bool(self._sent_back[robot])
        self._ahead[robot] = self._gap_left(robot, turn.t) if sent_back else math.nan
        self._legs[robot], self._leg_begun[robot] = self._turns.times[robot], turn.t
        self._direction[robot] = turn.direction
        self._own_leg[robot] = own
        self._sent_back[robot] = turn.direction == COUNTER_CLOCKWISE and not own
        self._compare_place(robot, turn)
        self._schedule_probe(robot, turn.t)

    def _compare_place(self, robot: int, turn: Turn) -> None:
        self._in_vain[robot] = False
        if turn.cause is TurnCause.EVEN_GAPS:
            return
        gained = self._gained[robot]
        self._gained[robot] = 0.0 if self._sent_back[robot] else math.nan
        if self._sent_back[robot] and self.team[robot] != _UNKNOWN:
            near = even_gaps.ONE_PLACE * self._feet.length / self.team[robot]
            self._in_vain[robot] = abs(gained) <= near  # nan, after a meeting: False

    def _accumulate(self, some: Indices, t: float, s: Reals) -> None:
        clockwise = self._direction[some] == CLOCKWISE
        elapsed = t - self._t[some]
        self._time[0, some] += np.where(clockwise, elapsed, 0.0)
        self._time[1, some] += np.where(clockwise, 0.0, elapsed)
        place = s[some]
        way = self._feet.difference(place, self._abscissa[some])
        self._progress[some] += way
        self._gained[some] += way
        self._t[some], self._abscissa[some] = t, place

    def _gap_left(self, robots: Indices | int, t: float) -> Reals:
        leg = self._leg_begun[robots]
        begun = np.where(np.isneginf(leg), self._begun[robots], leg)
        return np.asarray((t - begun) * self._closing_speed)

    # ---- estimate of the team -----------------------------------------------------------------

    def _start_counting(self, robot: int, t: float) -> None:
        self.team[robot] = self._probes[robot] = self._given[robot]
        self._counting[robot] = False
        self._count_from(robot, t)
        self._restart_check(robot, t)
        self._schedule_probe(robot, t)

    def _count_from(self, robot: int, t: float) -> None:
        self._since[robot] = t
        self._time[:, robot] = 0.0
        self._met[:, robot] = 0

    def _count_teams(self, some: Indices, t: float) -> None:
        if not some.size:
            return
        enough = self._time[:, some].min(axis=0) >= even_gaps.MIN_TIME * self._lap
        enough &= (self._met[:, some].min(axis=0) > 0) & self._counting[some]
        enough &= t - self._since[some] >= self._counting_laps[some] * self._lap
        for robot in some[enough].tolist():
            robots = self._opposing(1, robot) + max(self._opposing(0, robot), 1.0)
            self.team[robot] = max(2, round(robots))
            self._since[robot], self._probes[robot] = t, self.team[robot]
            self._blocked[robot] = False
            self._restart_check(robot, t)

    def _opposing(self, side: int, robot: int) -> float:
        time = max(float(self._time[side, robot]), 1.0)
        return int(self._met[side, robot]) * self._lap / 2.0 / time

    def _restart_check(self, robot: int, t: float) -> None:
        self._progress[robot] = 0.0
        self._check_at[robot] = t + even_gaps.CHECK_LAPS * self._lap

    def _check(self, some: Indices, t: float) -> None:
        expired = t - self._since[some] >= even_gaps.COUNT_LIFETIME
        due = expired | (t >= self._check_at[some])
        for robot, is_old in zip(some[due].tolist(), expired[due].tolist(), strict=True):
            if is_old:
                self._counting_laps[robot] = even_gaps.COUNTING_LAPS
                self._start_counting(robot, t)
                continue
            if self._progress[robot] < even_gaps.MIN_PROGRESS * self._feet.length:
                self._count_again(robot, t)
            self._restart_check(robot, t)

    def _count_again(self, robot: int, t: float) -> None:
        self._given[robot] = _UNKNOWN
        self._counting_laps[robot] = even_gaps.BLOCKED_LIFETIME / self._lap
        self._start_counting(robot, t)

    # ---- decision -----------------------------------------------------------------------------

    def _schedule_probe(self, robot: int, t: float) -> None:
        self._probe_at[robot] = t + self._lap * float(self._rngs[robot].uniform(0.5, 1.5))

    def _should_turn(self, some: Indices, t: float, keeps: Flags) -> Flags:
        team, due = self.team[some], t >= self._probe_at[some]
        counted = team != _UNKNOWN
        even = self._feet.length / np.maximum(team, 1)
        back = self._direction[some] == COUNTER_CLOCKWISE
        wide = self._sent_back[some] & (self._gap_left(some, t) >= even)
        probes = counted & ~back & due & (self._probes[some] > 0) & keeps & ~self._are_even(some)
        self._probes[some[probes]] -= 1
        searches = ~counted & due & ~self._blocked[some] & keeps
        searches &= self._searches[some] < even_gaps.MOST_SEARCHES
        self._searches[some[searches]] += 1
        ends = (wide | due) & ~self._in_vain[some]
        turns = np.where(counted, np.where(back, ends, probes), searches)
        return np.asarray(turns & keeps)


def _side(direction: int) -> int:
    return 0 if direction == CLOCKWISE else 1

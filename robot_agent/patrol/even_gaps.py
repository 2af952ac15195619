"""Modifier ``even_gaps``: robots circle a closed border one way, equally spaced, no messages.

Beyond the paper. Robots that meet turn back, so directions travel round the border as if robots
passed through each other. Between two that drive head-on the gap closes at twice the patrol speed
v, so each robot can estimate from the times of its meetings alone

    the number of robots that drive against it in one direction:  meetings / time * length / (2 v)

which, summed over both directions, is the number N of robots. Then all follow a convention:
clockwise is onwards. A robot turned back by a meeting drives back for length / N / (2 v), which
leaves it length / N behind the robot it met, and turns onwards again. If it meets the next robot
sooner, that one is turned back in its place, and so on until a wide gap is found and filled. One
that is turned back twice at one place has not found it: two robots can push each other back so for
ever, one of them between the other and a wreck, and leave the rest of the border to itself. It
drives back until a teammate ends that. A robot that has not measured the gap ahead as even probes:
it turns back once at a random time. Probing leaves even gaps even, and so does a random reversal if
the next one waits until its turn has gone round.

The worst idleness of the result is length / (N v), the minimum possible. The estimate of N expires
after an hour, or when the robot no longer gets round (a wreck on the border): then it patrols by
the paper's rules alone and estimates again, for an hour.
"""

from __future__ import annotations

import numpy as np

from maps.border import Border
from robot_agent.patrol.actions import PATROLLING, Action
from robot_agent.patrol.behaviors import CLOCKWISE, COUNTER_CLOCKWISE
from robot_agent.patrol.blocked_way import BlockedWay
from robot_agent.patrol.modifier import Override, OverrideReason
from robot_agent.patrol.situation import Situation
from robot_agent.patrol.supervisor import Choice
from robot_agent.patrol.turn_log import Turn, TurnCause, TurnLog

COUNTING_LAPS = 1.5  # of patrol by the rules alone, before the team is counted
TOLERANCE = 0.15  # of the gap ahead, within which it counts as even
ONE_PLACE = 1.0 / 16.0
"""Of an even gap, between two turns at one place. Of three robots without a wreck one such turn in
25 is so near the one before, with a wreck every second one."""
COUNT_LIFETIME = 3600.0  # s after which the team is counted anew
BLOCKED_LIFETIME = 3600.0
"""s for which the way round counts as blocked after the last sign of it: a wreck seen, no progress.
Robots that drive onwards towards a wreck crowd there, so few attempts are best."""
MIN_TIME = 0.45  # laps one way and the other, and a meeting each, before the team is counted
MIN_PROGRESS = 0.25  # laps onwards in every CHECK_LAPS that show that the way round is free
CHECK_LAPS = 1.5
REST_LAPS = 0.5
"""Without a random reversal after any turn: meanwhile the turn, which all robots met pass on, has
gone round the border at twice the patrol speed, and the gaps are even again. Beside a wreck too:
a robot that turns on its way to an end has just come from the other one, and both wait."""
SETTLED_LAPS = 1.0
MOST_SEARCHES = 3  # in vain: the robot seems to be alone
OWN_CAUSES = (TurnCause.CHANCE, TurnCause.EVEN_GAPS, TurnCause.COMMON)
_TURN = Override(OverrideReason.EVEN_GAPS, turn=TurnCause.EVEN_GAPS)
_NO_CHANCE = Override(OverrideReason.EVEN_GAPS, may_turn=False)


class EvenGaps:
    """Turns a robot whose action is Keep Going so that the gaps of the team become even."""

    def __init__(
        self,
        border: Border,
        speed: float,
        turns: TurnLog,
        rng: np.random.Generator,
        team_size: int = 0,
    ) -> None:
        """speed: patrol speed, m/s. team_size: number of robots, believed until the robot no
        longer gets round; 0: it is counted. The border must be closed.
        """
        self._border = border
        self._lap = border.length / speed  # s
        self._closing_speed = 2.0 * speed
        self._turns = turns
        self._rng = rng
        self._counting_laps = COUNTING_LAPS
        self._given = team_size or None
        self._t: float | None = None
        self._abscissa = 0.0
        self._direction = CLOCKWISE
        self._leg: Turn | None = None  # the last turn processed, which began the present leg
        self._begun = 0.0  # time of the first step; start of the leg before any turn
        self._ahead: float | None = None  # m to the robot ahead, if known
        self._gained: float | None = None  # m onwards since it was sent back, if that counts
        self._in_vain = False  # whether the present leg back is the second from one place
        self._way = BlockedWay(border)
        self._blocked = False  # the way round, by what the robot has seen: no probes
        self._counting = False  # meetings are counted from the first one on
        self._searches = 0  # turns to search the other direction, since the last meeting
        self.by_chance = True
        """Whether a robot that has counted its team may turn by its own chance."""
        self.suspended = False
        """Whether the robot follows common turns: it is neither counted nor turned here."""
        self.team: int | None = None
        """Estimated number of robots on the border, with this one; None while counting."""
        self._start_counting(0.0)

    def propose(
        self,
        situation: Situation,
        choice: Choice,  # noqa: ARG002 - only the action in force matters
        action: Action,
    ) -> Override | None:
        """Return a turn for even gaps; else, if the robot rests, no random reversal."""
        if self._way.is_found(situation, self._turns.latest):
            self._count_again(situation.t)
            self._blocked = True
        if situation.direction is None or action not in PATROLLING:
            return None
        keeps_going = action is Action.KEEP_GOING
        abscissa, direction = situation.foot.abscissa, situation.direction
        if self.suspended:
            self._hold(situation.t, abscissa, direction)
            return None
        if self.turns_back(situation.t, abscissa, direction, keeps_going=keeps_going):
            return _TURN
        return _NO_CHANCE if self._rests(situation.t, direction) else None

    def _rests(self, t: float, direction: int) -> bool:
        """Return whether there is to be no random reversal: soon after a turn, or on a leg back."""
        turned = self._leg is not None and t - self._leg.t < REST_LAPS * self._lap
        if self.team is None:
            return turned and self._blocked
        return turned or not self.by_chance or direction != CLOCKWISE

    def turns_back(self, t: float, abscissa: float, direction: int, *, keeps_going: bool) -> bool:
        """Return whether to turn back at t for the sake of even gaps.

        abscissa, m, and direction, +1 clockwise or -1, are those of a robot at the border;
        keeps_going: its action is Keep Going; only then is the result ever True.
        """
        if self._t is None:
            self._t, self._abscissa, self._begun = t, abscissa, t
            self._direction, self._leg = direction, self._turns.latest
            self._start_counting(t)
        self._process_turn()
        self._accumulate(t, abscissa)
        if self.team is None:
            self._count_team(t)
        else:
            self._check(t)
        return keeps_going and self._should_turn(t)

    def resume(self, t: float) -> None:
        """End the suspension at t: the gaps may not be even any more."""
        self.suspended = False
        self._schedule_probe(t)
        self._ahead, self._probes = None, self.team or 0

    def _hold(self, t: float, abscissa: float, direction: int) -> None:
        """Take what happens during the suspension for no observation."""
        self._t, self._abscissa, self._direction = t, abscissa, direction
        self._leg = self._turns.latest
        self._gained, self._in_vain = None, False
        self._restart_check(t)

    # ---- observations -------------------------------------------------------------------------

    def _process_turn(self) -> None:
        """Process a turn of the last step: a meeting, unless its cause is one of OWN_CAUSES."""
        turn = self._turns.latest
        if turn is None or turn is self._leg:
            return
        if turn.cause not in OWN_CAUSES:
            self._searches = 0
            if self._counting:
                self._met[self._direction] += 1
            else:
                self._count_from(turn.t)  # before it all robots may have driven one way
                self._counting = True
        back = self._direction == COUNTER_CLOCKWISE
        self._ahead = self._gap_left(turn.t) if back and self._sent_back else None
        self._leg, self._direction = turn, turn.direction
        self._compare_place(turn)
        self._schedule_probe(turn.t)

    def _compare_place(self, turn: Turn) -> None:
        """Note whether a turn sends the robot back from where it was sent back before."""
        self._in_vain = False
        if turn.cause is TurnCause.EVEN_GAPS:
            return
        gained, self._gained = self._gained, 0.0 if self._sent_back else None
        if gained is not None and self._sent_back and self.team is not None:
            self._in_vain = abs(gained) <= ONE_PLACE * self._border.length / self.team

    def _accumulate(self, t: float, abscissa: float) -> None:
        """Add the time since the last step to its direction, and the way to the progress, m."""
        assert self._t is not None
        self._time[self._direction] += t - self._t
        way = self._border.difference(abscissa, self._abscissa)
        self._progress += way
        if self._gained is not None:
            self._gained += way
        self._t, self._abscissa = t, abscissa

    @property
    def _sent_back(self) -> bool:
        """Whether the present leg is counter-clockwise and began at another robot."""
        leg = self._leg
        back = self._direction == COUNTER_CLOCKWISE
        return back and leg is not None and leg.cause not in OWN_CAUSES

    def _gap_left(self, t: float) -> float:
        """Return the distance to the robot met last, m, if this one turned onwards at t."""
        begun = self._begun if self._leg is None else self._leg.t
        return (t - begun) * self._closing_speed

    # ---- estimate of the team -----------------------------------------------------------------

    def _start_counting(self, t: float) -> None:
        self.team = self._given
        self._probes = self._given or 0
        self._counting = False
        self._count_from(t)
        self._restart_check(t)
        self._schedule_probe(t)

    def _count_from(self, t: float) -> None:
        self._since = t
        self._time = {CLOCKWISE: 0.0, COUNTER_CLOCKWISE: 0.0}
        self._met = {CLOCKWISE: 0, COUNTER_CLOCKWISE: 0}

    def _count_team(self, t: float) -> None:
        """Estimate the number of robots once there are enough observations."""
        shortest = min(self._time.values())
        enough = shortest >= MIN_TIME * self._lap and min(self._met.values()) > 0
        if self._counting and enough and t - self._since >= self._counting_laps * self._lap:
            # This robot itself drives back at times, so at least one does.
            robots = self._opposing(COUNTER_CLOCKWISE) + max(self._opposing(CLOCKWISE), 1.0)
            self.team = max(2, round(robots))
            self._since, self._probes, self._blocked = t, self.team, False
            self._restart_check(t)

    def _opposing(self, direction: int) -> float:
        """Return the mean number of robots that drive against one with this direction."""
        return self._met[direction] * self._lap / 2.0 / max(self._time[direction], 1.0)

    def _restart_check(self, t: float) -> None:
        self._progress, self._check_at = 0.0, t + CHECK_LAPS * self._lap

    def _check(self, t: float) -> None:
        """Count again once the estimate has expired, or for long if the way round is blocked."""
        if t - self._since >= COUNT_LIFETIME:
            self._counting_laps = COUNTING_LAPS
            self._start_counting(t)
        elif t >= self._check_at:
            if self._progress < MIN_PROGRESS * self._border.length:
                self._count_again(t)
            self._restart_check(t)

    def _count_again(self, t: float) -> None:
        """Patrol by the rules alone, as nobody seems to get round, and count meanwhile."""
        self._given, self._counting_laps = None, BLOCKED_LIFETIME / self._lap
        self._start_counting(t)

    # ---- decision -----------------------------------------------------------------------------

    def _schedule_probe(self, t: float) -> None:
        """Set the time of the next probing turn, 0.5 to 1.5 laps after t."""
        self._probe_at = t + self._lap * float(self._rng.uniform(0.5, 1.5))

    def _should_turn(self, t: float) -> bool:
        if self.team is None:
            return self._should_search(t)
        if self._direction == COUNTER_CLOCKWISE:
            if self._in_vain:
                return False
            even = self._border.length / self.team
            return (self._sent_back and self._gap_left(t) >= even) or t >= self._probe_at
        if t < self._probe_at or self._probes == 0 or self._is_even():
            return False
        self._probes -= 1
        return True

    def _should_search(self, t: float) -> bool:
        """Return whether to search the other direction: no meeting for long, and none expected."""
        if t < self._probe_at or self._blocked or self._searches == MOST_SEARCHES:
            return False
        self._searches += 1
        return True

    def is_settled(self, t: float) -> bool:
        """Whether the robot has driven clockwise for a lap without any turn, its team counted.

        Gaps that are not even are sent back or probed meanwhile, unless all probes were in vain.
        """
        begun = self._begun if self._leg is None else max(self._leg.t, self._begun)
        lasts = t - begun >= SETTLED_LAPS * self._lap
        return self.team is not None and self._direction == CLOCKWISE and lasts

    def _is_even(self) -> bool:
        """Return whether the gap ahead was measured and is even within the tolerance."""
        if self._ahead is None or self.team is None:
            return False
        even = self._border.length / self.team
        return abs(self._ahead - even) <= TOLERANCE * even

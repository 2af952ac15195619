"""Even gaps: all robots go round a closed border one way, equally spaced, without a word.

Beyond the paper. Robots that meet turn back, so directions travel round the border as if robots
passed through each other. Between two that go head-on the gap closes at twice the patrol speed v,
so each robot can learn from the times of its meetings alone

    how many go against it while it goes one way:  meetings / time * length / (2 v)

which, added up over both ways, is the number N of robots. Then it keeps to a convention: clockwise
is onwards. One that a meeting has sent back goes back for length / N / (2 v), which leaves it
length / N behind the robot it met, and turns onwards again. Should it meet the next one sooner,
that one is sent back in its place, and so on until a wide gap is found and filled. A robot that
does not know the gap ahead of it to be even tries again: it turns back once at a random time.
Even gaps stay even whoever tries.

The worst idleness of the result is length / (N v), the least possible. What is learnt holds until
it is old, or until the robot does not get round any more (a wreck on the border): then it patrols
by the paper's rules alone and learns again, for longer each time.
"""

from __future__ import annotations

import numpy as np

from maps.border import Border
from robot_agent.patrol.actions import PATROLLING, Action
from robot_agent.patrol.behaviors import CLOCKWISE, COUNTER_CLOCKWISE
from robot_agent.patrol.modifier import Override, OverrideReason
from robot_agent.patrol.situation import Situation
from robot_agent.patrol.supervisor import Choice
from robot_agent.patrol.turn_log import Turn, TurnCause, TurnLog

_LEARNING_LAPS = 1.5  # of patrol by the rules alone, before the team is counted
_LONGEST_LEARNING_LAPS = 12.0  # when the way round proves blocked again and again
_SLACK = 1.06  # of the gap to leave: a robot met at that distance was where it should be
_TOLERANCE = 0.15  # of the gap ahead, within which it counts as even
_MEMORY = 3600.0  # s after which the team is counted anew
_MIN_TIME = 0.45  # laps one way and the other, and a meeting each, before the team is counted
_MIN_PROGRESS = 0.5  # laps onwards in every _CHECK_LAPS that show that the way round is free
_CHECK_LAPS = 3.0
_OWN_CAUSES = (TurnCause.CHANCE, TurnCause.EVEN_GAPS)
_TURN = Override(OverrideReason.EVEN_GAPS, turn=TurnCause.EVEN_GAPS)
_NO_CHANCE = Override(OverrideReason.EVEN_GAPS, may_turn=False)


class EvenGaps:
    """Turns a robot that keeps going so that the gaps of the team become even."""

    def __init__(
        self, border: Border, speed: float, turns: TurnLog, rng: np.random.Generator
    ) -> None:
        """speed: of patrol, m/s. The border must be closed."""
        self._border = border
        self._lap = border.length / speed  # s
        self._closing_speed = 2.0 * speed
        self._turns = turns
        self._rng = rng
        self._learning_laps = _LEARNING_LAPS
        self._t: float | None = None
        self._abscissa = 0.0
        self._direction = CLOCKWISE
        self._leg: Turn | None = None  # the turn that began the present leg, as far as noticed
        self._begun = 0.0  # s; before any turn
        self._ahead: float | None = None  # m to the robot ahead, if known
        self._counting = False  # meetings are counted from the first one on
        self.team: int | None = None
        """Robots on the border as far as learnt, with this one; None while learning."""
        self._start_learning(0.0)

    def propose(
        self,
        situation: Situation,
        choice: Choice,  # noqa: ARG002 - only what is in force counts
        action: Action,
    ) -> Override | None:
        """Turn for even gaps; keep chance from turning a robot on its way to its gap."""
        if situation.direction is None or action not in PATROLLING:
            return None
        keeps_going = action is Action.KEEP_GOING
        abscissa, direction = situation.foot.abscissa, situation.direction
        if self.turns_back(situation.t, abscissa, direction, keeps_going=keeps_going):
            return _TURN
        return None if self.team is None or direction == CLOCKWISE else _NO_CHANCE

    def turns_back(self, t: float, abscissa: float, direction: int, *, keeps_going: bool) -> bool:
        """Tell whether to turn back at t, s, for the sake of even gaps.

        abscissa, m, and direction, +1 clockwise or -1, are those of a robot at the border;
        keeps_going: its action is Keep Going, so that it may choose its direction.
        """
        if self._t is None:
            self._t, self._abscissa, self._begun = t, abscissa, t
            self._direction, self._leg = direction, self._turns.latest
            self._start_learning(t)
        self._notice_turn()
        self._add_up(t, abscissa)
        if self.team is None:
            self._learn(t)
        else:
            self._check(t)
        return keeps_going and self._wants_to_turn(t)

    # ---- what is seen -------------------------------------------------------------------------

    def _notice_turn(self) -> None:
        """Take a turn of the last step: a meeting, unless the robot chose it."""
        turn = self._turns.latest
        if turn is None or turn is self._leg:
            return
        if turn.cause not in _OWN_CAUSES:
            if self._counting:
                self._met[self._direction] += 1
            else:
                self._count_from(turn.t)  # before it all may have gone one way
                self._counting = True
        back = self._direction == COUNTER_CLOCKWISE
        self._ahead = self._gap_left(turn.t) if back and self._sent_back else None
        self._leg, self._direction = turn, turn.direction
        self._wait(turn.t)

    def _add_up(self, t: float, abscissa: float) -> None:
        """Add up time and way."""
        assert self._t is not None
        self._time[self._direction] += t - self._t
        self._progress += self._border.difference(abscissa, self._abscissa)
        self._t, self._abscissa = t, abscissa

    @property
    def _sent_back(self) -> bool:
        """Whether the present way back began beside another robot."""
        leg = self._leg
        back = self._direction == COUNTER_CLOCKWISE
        return back and leg is not None and leg.cause not in _OWN_CAUSES

    def _gap_left(self, t: float) -> float:
        """Return how far behind the robot met last this one would be if it turned onwards, m."""
        begun = self._begun if self._leg is None else self._leg.t
        return (t - begun) * self._closing_speed

    # ---- what is learnt -----------------------------------------------------------------------

    def _start_learning(self, t: float) -> None:
        self.team = None
        self._tries = 0
        self._counting = False
        self._count_from(t)
        self._restart_check(t)
        self._wait(t)

    def _count_from(self, t: float) -> None:
        self._since = t
        self._time = {CLOCKWISE: 0.0, COUNTER_CLOCKWISE: 0.0}
        self._met = {CLOCKWISE: 0, COUNTER_CLOCKWISE: 0}

    def _learn(self, t: float) -> None:
        """Count the team once enough was seen."""
        least = min(self._time.values())
        enough = least >= _MIN_TIME * self._lap and min(self._met.values()) > 0
        if self._counting and enough and t - self._since >= self._learning_laps * self._lap:
            # While this one goes back there is at least one that does.
            others = self._against(COUNTER_CLOCKWISE) + max(self._against(CLOCKWISE), 1.0)
            self.team = max(2, round(others))
            self._since, self._tries = t, self.team
            self._restart_check(t)

    def _against(self, direction: int) -> float:
        """Return how many robots go against one that goes this way, on average."""
        return self._met[direction] * self._lap / 2.0 / max(self._time[direction], 1.0)

    def _restart_check(self, t: float) -> None:
        self._progress, self._check_at = 0.0, t + _CHECK_LAPS * self._lap

    def _check(self, t: float) -> None:
        """Learn anew what is old, and for longer each time if the way round is blocked."""
        if t - self._since >= _MEMORY:
            self._learning_laps = _LEARNING_LAPS
            self._start_learning(t)
        elif t >= self._check_at:
            if self._progress < _MIN_PROGRESS * self._border.length:
                self._learning_laps = min(2.0 * self._learning_laps, _LONGEST_LEARNING_LAPS)
                self._start_learning(t)
            self._restart_check(t)

    # ---- what is done -------------------------------------------------------------------------

    def _wait(self, t: float) -> None:
        """Put off the next try to a random time."""
        self._try_at = t + self._lap * float(self._rng.uniform(0.5, 1.5))

    def _wants_to_turn(self, t: float) -> bool:
        if self.team is None:
            return t >= self._try_at  # nobody met for long: look for somebody
        if self._direction == COUNTER_CLOCKWISE:
            even = self._border.length / self.team * _SLACK
            return (self._sent_back and self._gap_left(t) >= even) or t >= self._try_at
        if t < self._try_at or self._tries == 0 or self._is_even():
            return False
        self._tries -= 1
        return True

    def _is_even(self) -> bool:
        """Tell whether the gap ahead is known to be about that of even ones."""
        if self._ahead is None or self.team is None:
            return False
        even = self._border.length / self.team
        return abs(self._ahead - even) <= _TOLERANCE * even

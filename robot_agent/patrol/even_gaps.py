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
from robot_agent.patrol.behaviors import CLOCKWISE, COUNTER_CLOCKWISE
from robot_agent.patrol.settings import EvenGapsSettings

_MIN_TIME = 0.45  # laps one way and the other, and a meeting each, before the team is counted
_MIN_PROGRESS = 0.5  # laps onwards in every _CHECK_LAPS that show that the way round is free
_CHECK_LAPS = 3.0


class EvenGaps:
    """Decides when a robot that keeps going turns back to even out the gaps."""

    def __init__(
        self,
        settings: EvenGapsSettings,
        border: Border,
        speed: float,
        rng: np.random.Generator,
    ) -> None:
        """Speed of patrol in m/s; nothing is learnt yet. The border must be closed."""
        self._settings = settings
        self._border = border
        self._lap = border.length / speed  # s
        self._closing_speed = 2.0 * speed
        self._rng = rng
        self._learning_laps = settings.learning_laps
        self._t: float | None = None
        self._abscissa = 0.0
        self._direction = CLOCKWISE
        self._leg_start = 0.0  # s, when it turned last
        self._sent_back = False  # its way back began beside another robot
        self._ahead: float | None = None  # m to the robot ahead, if known
        self._counting = False  # meetings are counted from the first one on
        self.team: int | None = None
        """Robots on the border as far as learnt, with this one; None while learning."""
        self._start_learning(0.0)

    @property
    def goes_onwards(self) -> bool:
        """Whether the robot may reverse at random: not while it is on its way to its gap."""
        return self.team is None or self._direction == CLOCKWISE

    def turns_back(self, t: float, abscissa: float, direction: int, *, keeps_going: bool) -> bool:
        """Tell whether to turn back at t, s, for the sake of even gaps.

        abscissa, m, and direction, +1 clockwise or -1, are those of a robot at the border;
        keeps_going: its action is Keep Going, so that it may choose its direction.
        """
        if self._t is None:
            self._t, self._abscissa = t, abscissa
            self._direction, self._leg_start = direction, t
            self._start_learning(t)
        self._add_up(t, abscissa)
        if direction != self._direction:
            self._meet(t, direction)
        if self.team is None:
            self._learn(t)
        else:
            self._check(t)
        return keeps_going and self._wants_to_turn(t)

    def turned(self, t: float, direction: int) -> None:
        """Take note that the robot turned by its own choice (chance, or even gaps) at t, s."""
        back = self._direction == COUNTER_CLOCKWISE
        self._ahead = self._gap_left(t) if back and self._sent_back else None
        self._direction, self._leg_start, self._sent_back = direction, t, False
        self._wait(t)

    # ---- what is seen -------------------------------------------------------------------------

    def _add_up(self, t: float, abscissa: float) -> None:
        """Add up time and way."""
        assert self._t is not None
        self._time[self._direction] += t - self._t
        self._progress += self._border.difference(abscissa, self._abscissa)
        self._t, self._abscissa = t, abscissa

    def _meet(self, t: float, direction: int) -> None:
        """Take note of a meeting, which is what turned the robot."""
        if self._counting:
            self._met[self._direction] += 1
        else:
            self._count_from(t)  # before it all may have gone one way
            self._counting = True
        back = self._direction == COUNTER_CLOCKWISE
        self._ahead = self._gap_left(t) if back and self._sent_back else None
        self._direction, self._leg_start, self._sent_back = direction, t, not back
        self._wait(t)

    def _gap_left(self, t: float) -> float:
        """Return how far behind the robot met last this one would be if it turned onwards, m."""
        return (t - self._leg_start) * self._closing_speed

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
        if t - self._since >= self._settings.memory:
            self._learning_laps = self._settings.learning_laps
            self._start_learning(t)
        elif t >= self._check_at:
            if self._progress < _MIN_PROGRESS * self._border.length:
                longest = self._settings.longest_learning_laps
                self._learning_laps = min(2.0 * self._learning_laps, longest)
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
            even = self._border.length / self.team * self._settings.slack
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
        return abs(self._ahead - even) <= self._settings.tolerance * even

"""The modifier even_gaps on points moving on a ring: estimated team size and resulting gaps."""

import numpy as np
import pytest

from maps.border import Border
from maps.border_primitives import Arc
from robot_agent.patrol.actions import Action
from robot_agent.patrol.even_gaps import EvenGaps
from robot_agent.patrol.turn_log import Turn, TurnCause, TurnLog
from tests.robot_agent.patrol.situations import choice, situation

LENGTH, SPEED, STEP = 51.0, 0.35, 0.1
RADIUS = LENGTH / (2.0 * np.pi)
RING = Border([Arc((0.0, 0.0), RADIUS, np.pi, -2.0 * np.pi)], closed=True)


class Ring:
    """Points on a ring, in order, that turn back when they meet."""

    def __init__(self, places, directions, seed=0, blocked=None, team_size=0):
        self.t = 0.0
        self.place = np.array(places, dtype=float)
        self.direction = list(directions)
        self.logs = [TurnLog() for _ in places]
        self.modifiers = [
            EvenGaps(RING, SPEED, log, np.random.default_rng([seed, i]), team_size)
            for i, log in enumerate(self.logs)
        ]
        self.blocked = blocked  # index of a point that stands

    def run(self, duration):
        end = self.t + duration
        while self.t < end:
            self.step()

    def step(self):
        self.t += STEP
        moving = np.array(self.direction) * SPEED * STEP
        if self.blocked is not None:
            moving[self.blocked] = 0.0
        self.place = (self.place + moving) % LENGTH
        count = len(self.place)
        for one in range(count):
            other = (one + 1) % count
            ahead = RING.difference(self.place[other], self.place[one])
            if 0.0 <= ahead < 0.2 and count > 1:
                self.turn(one, -1, TurnCause.TEAMMATE)
                self.turn(other, 1, TurnCause.TEAMMATE)
        for i, modifier in enumerate(self.modifiers):
            if i == self.blocked:
                continue
            if modifier.turns_back(self.t, self.place[i], self.direction[i], keeps_going=True):
                self.turn(i, -self.direction[i], TurnCause.EVEN_GAPS)

    def turn(self, i, direction, cause):
        if direction != self.direction[i]:
            self.direction[i] = direction
            self.logs[i].add(Turn(self.t, self.place[i], direction, cause))

    def gaps(self):
        return np.diff(np.sort(self.place), append=np.sort(self.place)[0] + LENGTH)


@pytest.mark.parametrize(
    ("count", "directions"),
    [(2, (1, -1)), (3, (1, -1, 1)), (3, (-1, 1, -1)), (3, (1, 1, 1)), (3, (-1, -1, -1))],
)
def test_robots_converge_to_one_direction_evenly_spaced(count, directions):
    places = np.sort(np.random.default_rng(count).uniform(0.0, LENGTH, count))
    ring = Ring(places, directions)
    ring.run(3000.0)
    assert [modifier.team for modifier in ring.modifiers] == [count] * count
    assert ring.direction == [1] * count
    assert ring.gaps() == pytest.approx(np.full(count, LENGTH / count), rel=0.2)


def test_a_robot_alone_searches_three_times_and_then_goes_round():
    ring = Ring([1.0], [1])
    ring.run(3000.0)
    assert (
        sum(1 for way in (1, -1) for _ in ring.logs[0].latest_first(TurnCause.EVEN_GAPS, way)) == 3
    )


def test_no_turn_unless_the_action_is_keep_going():
    modifier = EvenGaps(RING, SPEED, TurnLog(), np.random.default_rng(0))
    asked = [modifier.turns_back(0.1 * i, 0.0, 1, keeps_going=False) for i in range(6000)]
    assert not any(asked)


def test_with_a_wreck_on_the_border_all_the_rest_is_visited():
    ring = Ring([1.0, 18.0, 35.0], [1, 1, -1])
    ring.run(2500.0)
    assert ring.direction == [1, 1, 1]
    ring.blocked = 0
    wreck = ring.place[0]
    ring.run(900.0)  # until they have detected the blocked way round
    visited = set()
    for _ in range(12000):
        ring.step()
        visited |= {int(ring.place[robot]) for robot in (1, 2)}
    beside = {cell for cell in range(51) if abs(RING.difference(cell + 0.5, wreck)) <= 2.0}
    assert visited | beside == set(range(51))


def test_a_robot_that_knows_the_way_to_be_blocked_patrols_by_the_rules_alone():
    log = TurnLog()
    modifier = EvenGaps(RING, SPEED, log, np.random.default_rng(1), team_size=3)
    before = (-RADIUS - 2.0, 0.0)
    for t in np.arange(0.0, 120.0, STEP):
        wreck = before if t % 50.0 > 48.0 else None
        now = situation(t, (-RADIUS, 0.0), border=RING, direction=1, teammate=wreck)
        modifier.propose(now, choice(Action.KEEP_GOING), Action.KEEP_GOING)
        if wreck is not None and t % 50.0 > 49.85:
            log.add(Turn(t, 0.0, -1, TurnCause.TEAMMATE))
    assert modifier.team is None
    soon = situation(125.0, (-RADIUS, 0.0), border=RING, direction=-1)
    override = modifier.propose(soon, choice(Action.KEEP_GOING), Action.KEEP_GOING)
    assert override is not None
    assert not override.may_turn, "no random reversal soon after a turn"
    later = situation(900.0, (-RADIUS, 0.0), border=RING, direction=1)
    assert modifier.propose(later, choice(Action.KEEP_GOING), Action.KEEP_GOING) is None


def test_no_random_reversal_until_the_last_turn_has_gone_round_the_border():
    log = TurnLog()
    modifier = EvenGaps(RING, SPEED, log, np.random.default_rng(1))

    def proposed(t, direction=1):
        now = situation(t, (-RADIUS, 0.0), border=RING, direction=direction)
        return modifier.propose(now, choice(Action.KEEP_GOING), Action.KEEP_GOING)

    assert proposed(0.0) is None, "a team that is not counted yet patrols by the rules"
    modifier.team = 3
    assert proposed(1.0) is None, "no turn yet"
    log.add(Turn(2.0, 0.0, 1, TurnCause.TEAMMATE))
    round_at_twice_the_speed = LENGTH / (2.0 * SPEED)
    for t in (3.0, 2.0 + 0.99 * round_at_twice_the_speed):
        override = proposed(t)
        assert override is not None
        assert not override.may_turn
    assert proposed(2.0 + 1.01 * round_at_twice_the_speed) is None


def alone(place):
    """Return a ring of one robot that believes in a team of three; the test turns it back."""
    return Ring([place], [1], team_size=3)


def meet(ring):
    """Turn the robot back as one that comes towards it does."""
    ring.turn(0, -ring.direction[0], TurnCause.TEAMMATE)


def drive(ring, duration):
    """Run until the robot turns by itself, and return how far; None: it does not."""
    end, begun, leg = ring.t + duration, ring.place[0], ring.logs[0].latest
    while ring.t < end:
        ring.step()
        if ring.logs[0].latest is not leg:
            return abs(RING.difference(ring.place[0], begun))
    return None


@pytest.mark.parametrize(("short", "ends"), [(0.0, False), (0.9, False), (1.3, True), (5.0, True)])
def test_a_robot_sent_back_twice_from_one_place_goes_back_until_a_teammate_ends_it(short, ends):
    robot = alone(20.0)
    drive(robot, 1.0)
    meet(robot)
    back = drive(robot, 60.0)
    assert back == pytest.approx(LENGTH / 3.0 / 2.0, abs=0.1)
    assert drive(robot, (back - short) / SPEED) is None
    meet(robot)
    lap = LENGTH / SPEED
    if ends:
        assert drive(robot, lap) == pytest.approx(back, abs=0.1)
    else:
        assert drive(robot, 2.0 * lap) is None


def test_a_robot_sent_back_from_one_place_after_another_meeting_goes_back_an_even_share():
    robot = alone(20.0)
    for _ in range(3):
        drive(robot, 1.0)
        meet(robot)
        drive(robot, 10.0)
        meet(robot)  # one behind, which goes back in its place
        drive(robot, 9.0)
    meet(robot)
    assert drive(robot, 60.0) == pytest.approx(LENGTH / 3.0 / 2.0, abs=0.1)

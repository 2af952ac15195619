"""Even gaps, by itself on points that go round a ring: what is learnt, and what comes of it."""

import numpy as np
import pytest

from maps.border import Border
from maps.border_primitives import Arc
from robot_agent.patrol.even_gaps import EvenGaps
from robot_agent.patrol.turn_log import Turn, TurnCause, TurnLog

LENGTH, SPEED, STEP = 51.0, 0.35, 0.1
RADIUS = LENGTH / (2.0 * np.pi)
RING = Border([Arc((0.0, 0.0), RADIUS, np.pi, -2.0 * np.pi)], closed=True)


class Ring:
    """Points on a ring, in order, that turn back where they meet."""

    def __init__(self, places, directions, seed=0, blocked=None):
        self.t = 0.0
        self.place = np.array(places, dtype=float)
        self.direction = list(directions)
        self.logs = [TurnLog() for _ in places]
        self.minds = [
            EvenGaps(RING, SPEED, log, np.random.default_rng([seed, i]))
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
        for i, mind in enumerate(self.minds):
            if i == self.blocked:
                continue
            if mind.turns_back(self.t, self.place[i], self.direction[i], keeps_going=True):
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
def test_robots_come_to_go_one_way_evenly_spaced(count, directions):
    places = np.sort(np.random.default_rng(count).uniform(0.0, LENGTH, count))
    ring = Ring(places, directions)
    ring.run(3000.0)
    assert [mind.team for mind in ring.minds] == [count] * count
    assert ring.direction == [1] * count
    assert ring.gaps() == pytest.approx(np.full(count, LENGTH / count), rel=0.2)


def test_nothing_is_decided_for_one_that_does_not_keep_going():
    mind = EvenGaps(RING, SPEED, TurnLog(), np.random.default_rng(0))
    asked = [mind.turns_back(0.1 * i, 0.0, 1, keeps_going=False) for i in range(6000)]
    assert not any(asked)


def test_what_the_way_round_leaves_of_the_border_is_driven_on_though_a_wreck_blocks_it():
    ring = Ring([1.0, 18.0, 35.0], [1, 1, -1])
    ring.run(2500.0)
    assert ring.direction == [1, 1, 1]
    ring.blocked = 0
    wreck = ring.place[0]
    ring.run(900.0)  # until they no longer wait for the way round
    visited = set()
    for _ in range(12000):
        ring.step()
        visited |= {int(ring.place[robot]) for robot in (1, 2)}
    beside = {cell for cell in range(51) if abs(RING.difference(cell + 0.5, wreck)) <= 2.0}
    assert visited | beside == set(range(51))

"""A way round the border is blocked by a teammate that stands at one place, and by no other."""

import pytest

from maps.border import Border
from maps.border_primitives import Arc
from robot_agent.patrol.blocked_way import BlockedWay
from robot_agent.patrol.turn_log import Turn, TurnCause
from tests.robot_agent.patrol.situations import situation

RING = Border([Arc((0.0, 0.0), 8.0, 3.14159, -6.28318)], closed=True)


def met(way: BlockedWay, turn: Turn, before: Turn | None = None, speed: float = 0.0) -> bool:
    """Return what is found at a turn by a teammate seen for 1.7 s before, at a speed, m/s.

    before: the turn before it.
    """
    for step in range(18):
        mate = (0.1 * step * speed, 8.0)
        now = situation(turn.t - 1.7 + 0.1 * step, (-2.5, 8.0), teammate=mate)
        assert not way.is_found(now, before)
    return way.is_found(situation(turn.t + 0.1, (-2.5, 8.0)), turn)


def turn(t: float, abscissa: float, direction: int = -1, cause: TurnCause = TurnCause.TEAMMATE):
    return Turn(t, abscissa, direction, cause)


FIRST = turn(11.7, 5.0)


def test_the_second_meeting_with_a_teammate_that_stands_at_one_place_shows_it():
    way = BlockedWay(RING)
    assert not met(way, FIRST)
    assert met(way, turn(61.7, 5.6), FIRST)


def test_a_teammate_that_comes_closer_does_not():
    way = BlockedWay(RING)
    assert not met(way, FIRST, speed=0.35)
    assert not met(way, turn(61.7, 5.0), FIRST, speed=0.35)


@pytest.mark.parametrize(
    "other",
    [turn(61.7, 8.0), turn(61.7, 5.0, 1), turn(61.7, 5.0, cause=TurnCause.CHANCE)],
    ids=["elsewhere", "the other way", "by chance"],
)
def test_another_turn_does_not(other):
    way = BlockedWay(RING)
    assert not met(way, FIRST)
    assert not met(way, other, FIRST)

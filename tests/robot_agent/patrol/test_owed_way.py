"""After a random reversal none until the way it turned from was driven, or somebody met there."""

import math

import pytest

from maps.border import Border
from maps.border_primitives import Arc, Segment
from robot_agent.patrol.owed_way import OwedWay

LINE = Border([Segment((0.0, 0.0), (20.0, 0.0))], closed=False)
RING = Border([Arc((0.0, 0.0), 20.0 / math.tau, math.pi, -math.tau)], closed=True)


def owed(steps, *, border=LINE, turned_at=10.0, from_direction=1):
    """Whether the way is owed at each (abscissa, direction) after a turn."""
    way = OwedWay(border)
    way.begin(turned_at, from_direction)
    return [way.is_owed(s, direction) for s, direction in steps]


def test_nothing_is_owed_at_first():
    assert not OwedWay(LINE).is_owed(3.0, 1)


@pytest.mark.parametrize("direction", [1, -1])
def test_owed_until_it_has_driven_past_the_place(direction):
    """It rolls on a little, goes back, is sent on, and comes by."""
    steps = [(0.2, -1), (-4.0, -1), (-4.0, 1), (-0.1, 1), (0.9, 1), (1.1, 1), (-3.0, -1)]
    found = owed(
        [(10.0 + direction * s, direction * d) for s, d in steps], from_direction=direction
    )
    assert found == [True] * 5 + [False] * 2


def test_whoever_is_sent_back_on_that_way_owes_nothing_more():
    assert owed([(9.0, -1), (6.0, 1), (8.0, 1), (8.0, -1)]) == [True, True, True, False]


def test_to_go_on_the_other_way_is_no_return():
    assert owed([(9.0, -1), (3.0, -1), (1.0, -1)]) == [True] * 3


def test_a_closed_border_is_driven_past_from_behind_too():
    """Half way round backwards the place lies ahead again."""
    steps = [(s % 20.0, -1) for s in (10.2, 6.0, 1.0, -0.5, -2.0)]
    assert owed(steps, border=RING) == [True, True, True, False, False]


def test_a_new_turn_begins_a_new_debt():
    way = OwedWay(LINE)
    way.begin(10.0, 1)
    way.begin(5.0, -1)
    assert [way.is_owed(s, d) for s, d in ((6.0, 1), (5.0, -1), (3.9, -1))] == [True, True, False]

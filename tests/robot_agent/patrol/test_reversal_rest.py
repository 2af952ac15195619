"""No random reversal for a while once a teammate stands on the border."""

import numpy as np
import pytest

from robot_agent.patrol.reversal_rest import ReversalRest

DURATION = 20.0  # s


def resting(places, *, gamma=1.0, rest=None):
    """The times, s, at which reversals rest; places of a teammate ten times a second, or None."""
    rest = rest or ReversalRest(DURATION)
    return [k / 10.0 for k, place in enumerate(places) if rest.rests(k / 10.0, place, gamma)]


def test_a_teammate_that_stands_for_a_second_begins_a_rest():
    times = resting([(0.0, 0.0)] * 12 + [None] * 400)
    assert times == pytest.approx(np.arange(1.0, 1.0 + DURATION, 0.1))


@pytest.mark.parametrize(
    "places",
    [
        [(0.0, 0.0)] * 10 + [None] * 5,
        [(0.035 * k, 0.0) for k in range(60)],  # it patrols
        ([(0.0, 0.0)] * 8 + [None]) * 20,  # sight ends each time
    ],
)
def test_a_glance_or_one_that_moves_begins_none(places):
    assert resting(places) == []


def test_errors_of_sight_do_not_move_it():
    rng = np.random.default_rng(1)
    assert resting([tuple(rng.uniform(-0.05, 0.05, 2)) for _ in range(30)])[0] == 1.0


def test_away_from_the_border_it_begins_none():
    assert resting([(0.0, 0.0)] * 50, gamma=0.0) == []


def test_after_a_rest_chance_has_as_long_however_often_the_wreck_is_seen():
    times = np.array(resting([(0.0, 0.0)] * 900))
    begins = times[np.flatnonzero(np.diff(times, prepend=-9.0) > 0.15)]
    assert begins == pytest.approx([1.0, 1.0 + 2 * DURATION, 1.0 + 4 * DURATION], abs=0.11)


def test_no_duration_no_rest():
    assert resting([(0.0, 0.0)] * 50, rest=ReversalRest(0.0)) == []

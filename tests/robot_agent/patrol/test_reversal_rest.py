"""No random reversal for a while once a teammate stands on the border."""

import numpy as np
import pytest

from robot_agent.patrol.reversal_rest import ReversalRest

DURATION = 20.0  # s


def resting(places, *, gamma=1.0, rest=None):
    """The times, s, at which reversals rest; places of a teammate ten times a second, or None."""
    rest = rest or ReversalRest(DURATION)
    return [k / 10.0 for k, place in enumerate(places) if rest.rests(k / 10.0, place, gamma)]


def test_a_teammate_that_stands_begins_a_rest_even_where_it_is_soon_out_of_sight():
    times = resting([(0.0, 0.0)] * 12 + [None] * 400)
    assert times == pytest.approx(np.arange(4.0, 4.0 + DURATION, 0.1))


@pytest.mark.parametrize(
    "places",
    [
        [(0.0, 0.0)] * 10 + [None] * 60,  # a glance
        [(0.0, 0.0)] * 2 + [None] * 31 + [(0.0, 0.0)] * 9 + [None] * 60,  # two glances
        [(0.035 * k, 0.0) for k in range(80)],  # it patrols
        [(0.035 * min(k, 8), 0.0) for k in range(80)],  # it came, and turns where it stands
        [(0.035 * max(k - 33, 0), 0.0) for k in range(80)],  # it had turned, and goes
    ],
)
def test_a_glance_or_one_that_moves_begins_none(places):
    assert resting(places) == []


def test_errors_of_sight_do_not_move_it():
    rng = np.random.default_rng(1)
    places = [tuple(rng.uniform(-0.05, 0.05, 2)) for _ in range(50)]
    assert resting(places)[0] == pytest.approx(4.0)


def test_away_from_the_border_it_begins_none():
    assert resting([(0.0, 0.0)] * 80, gamma=0.0) == []


def test_after_a_rest_chance_has_as_long_however_often_the_wreck_is_seen():
    times = np.array(resting([(0.0, 0.0)] * 900))
    begins = times[np.flatnonzero(np.diff(times, prepend=-9.0) > 0.15)]
    assert begins == pytest.approx([4.0, 4.0 + 2 * DURATION, 4.0 + 4 * DURATION], abs=0.11)


def test_no_duration_no_rest():
    assert resting([(0.0, 0.0)] * 80, rest=ReversalRest(0.0)) == []

"""The random reversal: period, phase, probability."""

import numpy as np
import pytest

from robot_agent.patrol.reversal import RandomReversal


def times(probability, *, seed=1, duration=300.0, permitted=lambda t: True, distribution="fixed"):
    reversal = RandomReversal(27.0, probability, np.random.default_rng(seed), distribution)
    steps = (0.1 * k for k in range(int(duration * 10)))
    return [t for t in steps if reversal.due(t, permitted=permitted(t))]


def test_fixed_intervals_are_the_period_after_a_random_phase():
    found = times(1.0)
    assert 0.0 <= found[0] <= 27.1
    assert np.diff(found) == pytest.approx(27.0, abs=0.11)


def test_phases_differ_and_cover_the_period():
    first = [times(1.0, seed=seed, duration=30.0)[0] for seed in range(40)]
    assert min(first) < 5.0
    assert max(first) > 22.0


def test_share_of_reversals_is_the_probability():
    assert times(0.0) == []
    count = len(times(0.25, duration=27.0 * 2000, seed=3))
    assert count == pytest.approx(500, abs=60)


def test_scheduled_time_not_permitted_is_lost():
    found = times(1.0, permitted=lambda t: t > 60.0)
    assert found[0] > 60.0
    assert (found[0] - times(1.0)[0]) % 27.0 == pytest.approx(0.0, abs=0.2)


def test_same_seed_gives_the_same_times():
    assert times(0.5, seed=9) == times(0.5, seed=9)


@pytest.mark.parametrize(("distribution", "deviation"), [("uniform", 15.6), ("exponential", 27.0)])
def test_distributions_have_the_period_as_mean(distribution, deviation):
    pauses = np.diff(times(1.0, duration=27.0 * 1500, distribution=distribution))
    assert pauses.mean() == pytest.approx(27.0, rel=0.08)
    assert pauses.std() == pytest.approx(deviation, rel=0.1)

"""The cheapest assignment: SciPy finds the same pairs."""

import math

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment

from robot_agent.perception.assignment import cheapest_pairs

FAR = 1e6


def pairs_of_scipy(cost) -> list[tuple[int, int]]:
    rows, columns = linear_sum_assignment(np.minimum(cost, FAR))
    pairs = zip(rows.tolist(), columns.tolist(), strict=True)
    return [(row, column) for row, column in pairs if cost[row, column] < FAR]


@pytest.mark.parametrize("barred", [0.0, 0.3, 0.7, 0.95])
def test_pairs_are_those_of_scipy(barred):
    rng = np.random.default_rng(1)
    for _ in range(400):
        cost = rng.uniform(0.0, 11.8, size=rng.integers(1, 13, size=2))
        cost[rng.random(cost.shape) < barred] = math.inf
        assert cheapest_pairs(cost.tolist()) == pairs_of_scipy(cost)


def test_crowd_is_assigned_as_by_scipy():
    cost = np.random.default_rng(2).exponential(4.0, size=(40, 60))
    cost[cost > 11.8] = math.inf
    assert cheapest_pairs(cost.tolist()) == pairs_of_scipy(cost)


def test_most_pairs_are_made_before_the_cheapest():
    assert cheapest_pairs([[0.1, 5.0], [0.2, math.inf]]) == [(0, 1), (1, 0)]


def test_nothing_to_assign_gives_no_pairs():
    assert cheapest_pairs([]) == []
    assert cheapest_pairs([[], []]) == []
    assert cheapest_pairs([[math.inf]]) == []

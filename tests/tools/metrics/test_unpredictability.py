"""Entropies of return times, on patrols whose values are known."""

import numpy as np
import pytest

from maps.border import Border
from maps.border_primitives import Segment
from tools.metrics.border_visits import BorderVisits, PlaceVisits, border_visits
from tools.metrics.unpredictability import entropy, unpredictability_figures

LINE = Border([Segment((0.0, 0.0), (20.0, 0.0))], closed=False)


def bits(visits: BorderVisits) -> tuple[float, float]:
    figures = unpredictability_figures(visits)["unpredictability"]
    return figures["per_place_bit"], figures["conditional_bit"]


def process(intervals: np.ndarray, places: int = 1) -> BorderVisits:
    """Visits of some places, each 1 s long, with the same intervals, s, by robots of one way."""
    arrivals = np.concatenate(([0.0], np.cumsum(intervals)))
    ways = np.ones(len(arrivals), dtype=np.int8)
    one = PlaceVisits(arrivals, arrivals + 1.0, ways, 0.0, float(arrivals[-1]) + 1.0)
    return BorderVisits(
        np.arange(2.0), np.zeros(places), np.zeros((2, places), bool), [one] * places, True
    )


def test_clockwork_is_foretold_though_its_places_differ() -> None:
    t = np.arange(0.0, 4000.0, 0.1)
    s = 20.0 * (1.0 - np.abs((t / 42.0) % 2.0 - 1.0))  # a robot shuttles on a line
    per_place, conditional = bits(border_visits(LINE, [np.column_stack((s, 0.0 * s))], t))
    assert per_place <= 1.0  # two intervals in turn at most places
    assert conditional < 0.02


def test_one_interval_gives_no_bit_and_two_in_turn_one_that_is_foretold() -> None:
    assert bits(process(np.full(100, 48.6))) == (0.0, 0.0)
    per_place, conditional = bits(process(np.tile((25.0, 65.0), 100), places=3))
    assert per_place == pytest.approx(1.0, abs=1e-3)
    assert conditional == 0.0


def test_two_intervals_by_the_toss_of_a_coin_are_one_bit_whatever_is_known() -> None:
    rng = np.random.default_rng(1)
    per_place, conditional = bits(process(rng.choice((25.0, 65.0), 4000)))
    assert per_place == pytest.approx(1.0, abs=0.01)
    assert conditional == pytest.approx(1.0, abs=0.01)


def test_entropy_of_known_counts() -> None:
    assert entropy([4]) == 0.0
    assert entropy([1, 1, 1, 1]) == pytest.approx(2.0)


def test_no_visits_give_none() -> None:
    assert set(unpredictability_figures(None)["unpredictability"].values()) == {None}

"""Probability that an intruder at the border is seen."""

import numpy as np
import pytest

from maps.border import Border
from maps.border_primitives import Segment
from tools.metrics.border_visits import BorderVisits, PlaceVisits, border_visits
from tools.metrics.intruder_exposure import DWELL_S, intruder_figures

LINE = Border([Segment((0.0, 0.0), (20.0, 0.0))], closed=False)


def seen(visits: BorderVisits | None) -> dict[str, dict[str, float]]:
    figures = intruder_figures(visits)["intruder_seen"]
    assert figures is not None
    return figures


def test_random_intruder_is_seen_least_at_the_place_of_least_chance() -> None:
    t = np.arange(0.0, 4000.0, 0.1)
    s = 20.0 * (1.0 - np.abs((t / 40.0) % 2.0 - 1.0))
    random = seen(border_visits(LINE, [np.column_stack((s, 0.0 * s))], t))["random"]
    # At the ends a visit every 80 s; in the middle, every 40 s, nobody waits for longer than 40 s.
    assert random["20"] == pytest.approx(0.25, abs=0.03)
    assert random["60"] == pytest.approx(0.75, abs=0.03)
    assert random["90"] == 1.0


def test_watcher_of_a_shuttling_robot_strikes_when_it_has_left_for_the_longer_way() -> None:
    t = np.arange(0.0, 4000.0, 0.1)
    s = 20.0 * (1.0 - np.abs((t / 40.0) % 2.0 - 1.0))
    watcher = seen(border_visits(LINE, [np.column_stack((s, 0.0 * s))], t))["watcher"]
    assert watcher["20"] == watcher["40"] == watcher["60"] == 0.0
    assert watcher["90"] == 1.0


def test_watcher_learns_nothing_from_a_patrol_without_memory() -> None:
    rng = np.random.default_rng(1)
    gaps = rng.exponential(50.0, 20_000)
    arrivals = np.cumsum(gaps)
    ways = np.ones(len(arrivals), dtype=np.int8)
    place = PlaceVisits(arrivals, arrivals, ways, 0.0, float(arrivals[-1]))
    visits = BorderVisits(np.arange(2.0), np.zeros(1), np.ones((2, 1), bool), [place], True)
    watcher = seen(visits)["watcher"]
    for dwell in DWELL_S:
        assert watcher[f"{dwell:g}"] == pytest.approx(1.0 - np.exp(-dwell / 50.0), abs=0.03)


def test_run_shorter_than_the_dwell_time_gives_none() -> None:
    t = np.arange(0.0, 25.0, 0.1)
    figures = seen(border_visits(LINE, [np.zeros((t.size, 2))], t))
    assert [chance is None for chance in figures["random"].values()] == [d > 20.0 for d in DWELL_S]
    assert set(figures["watcher"].values()) == {None}
    assert intruder_figures(None) == {"intruder_seen": None}

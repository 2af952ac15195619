"""Probability that an intruder at the border is seen."""

import numpy as np
import pytest

from maps.border import Border
from maps.border_primitives import Segment
from tools.metrics.idleness import border_visits
from tools.metrics.intruder_exposure import DWELL_S, intruder_figures


def test_probabilities_follow_from_the_gaps() -> None:
    border = Border([Segment((0.0, 0.0), (20.0, 0.0))], closed=False)
    t = np.arange(0.0, 400.0, 0.1)
    # To and fro between s = 0 and 20 at 0.5 m/s: the ends wait 80 s, the middle 40 s.
    s = 20.0 * (1.0 - np.abs((t / 40.0) % 2.0 - 1.0))
    seen = intruder_figures(border_visits(border, [np.column_stack((s, 0.0 * s))], t))
    figures = seen["intruder_seen"]
    nearest_the_ends = (pytest.approx(0.25, abs=0.01), pytest.approx(19.75, abs=0.01))
    assert figures["weakest_place_m"] in nearest_the_ends
    at_end = dict(zip(figures["dwell_s"], figures["weakest_place"], strict=True))
    anywhere = dict(zip(figures["dwell_s"], figures["any_place"], strict=True))
    assert at_end[30.0] == pytest.approx(30.0 / 80.0, abs=0.05)
    assert at_end[120.0] == anywhere[120.0] == 1.0
    assert anywhere[30.0] > at_end[30.0]


def test_run_shorter_than_the_dwell_time_gives_none() -> None:
    border = Border([Segment((0.0, 0.0), (20.0, 0.0))], closed=False)
    t = np.arange(0.0, 20.0, 0.1)
    seen = intruder_figures(border_visits(border, [np.zeros((t.size, 2))], t))["intruder_seen"]
    assert [chance is None for chance in seen["any_place"]] == [d > 20.0 for d in DWELL_S]
    assert intruder_figures(None) == {"intruder_seen": None}

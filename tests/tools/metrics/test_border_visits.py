"""Visits of places: stays, ways, and what begin and end cut off."""

import numpy as np
import pytest

from maps.border import Border
from maps.border_primitives import Segment
from tools.metrics.border_visits import VISIT_RADIUS, border_visits

LINE = Border([Segment((0.0, 0.0), (20.0, 0.0))], closed=False)
T = np.arange(0.0, 200.0, 0.1)


def test_each_stay_has_arrival_departure_and_the_way_it_was_left() -> None:
    s = 20.0 * (1.0 - np.abs((T / 40.0) % 2.0 - 1.0))  # 0.5 m/s to and fro, from 0
    visits = border_visits(LINE, [np.column_stack((s, 0.0 * s))], T)
    place = visits.places[int(np.argmin(np.abs(visits.abscissae - 5.0)))]
    half = VISIT_RADIUS / 0.5
    assert place.arrivals == pytest.approx(
        [10 - half, 70 - half, 90 - half, 150 - half, 170 - half], abs=0.11
    )
    assert place.departures == pytest.approx(
        [10 + half, 70 + half, 90 + half, 150 + half, 170 + half], abs=0.11
    )
    assert place.ways.tolist() == [1, -1, 1, -1, 1]
    assert place.gaps == pytest.approx([59, 19, 59, 19], abs=0.21)
    assert place.cut == pytest.approx((9.5, 29.4), abs=0.11)
    assert visits.passing == pytest.approx(1.0, abs=0.11)


def test_a_place_never_visited_is_cut_off_all_along() -> None:
    visits = border_visits(LINE, [np.tile((2.0, 0.0), (T.size, 1))], T)
    assert visits.places[-1].cut == pytest.approx((T[-1], T[-1]))
    assert visits.places[-1].gaps.size == 0

"""Bounds of detection, against published and hand-computed values."""

import pytest

from maps.border import Border
from maps.border_primitives import Segment
from tools.metrics.detection_bounds import bound_figures, random_bound, turning_together


def test_even_visits_bound_what_a_random_moment_meets() -> None:
    assert random_bound(51.0, 3, 0.35, 20.0) == pytest.approx(20.0 / 48.571, abs=1e-3)
    assert random_bound(51.0, 3, 0.35, 60.0) == 1.0


@pytest.mark.parametrize(("dwell", "best"), [(24.0, 0.0), (30.0, 0.10), (40.0, 0.36), (45.0, 0.42)])
def test_optimum_of_robots_that_turn_together(dwell: float, best: float) -> None:
    assert turning_together(51.0, 3, 0.35, dwell) == pytest.approx(best, abs=0.005)


def test_intruder_longer_than_an_interval_is_always_seen() -> None:
    assert turning_together(51.0, 3, 0.35, 60.0) == pytest.approx(1.0)


def test_open_border_has_no_optimum_of_turning_together() -> None:
    line = Border([Segment((0.0, 0.0), (51.0, 0.0))], closed=False)
    figures = bound_figures(line, 3, 0.35)["intruder_bound"]
    assert set(figures["turning_together"].values()) == {None}
    assert figures["random"]["90"] == 1.0

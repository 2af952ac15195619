from __future__ import annotations

import math

import numpy as np
import pytest

from maps.border import Border
from maps.border_primitives import Segment
from tools.monitor.coverage import Coverage

LINE = Border([Segment((0.0, 0.0), (10.0, 0.0))], closed=False)


def test_unvisited_points_are_idle_since_the_start() -> None:
    coverage = Coverage(LINE, 100.0)
    assert coverage.average(110.0) == pytest.approx(10.0)
    assert not coverage.seen().any()


def test_pass_along_the_border_visits_every_point() -> None:
    coverage = Coverage(LINE, 0.0)
    for t in np.arange(0.0, 20.01, 0.2):
        coverage.visit([(0.5 * t, 0.1)], float(t))
    assert coverage.seen().all()
    idle = coverage.idle(20.0)
    assert idle[0] == pytest.approx(20.0, abs=1.0)
    assert idle[-1] == pytest.approx(0.0, abs=0.2)
    assert coverage.average(20.0) == pytest.approx(10.0, abs=1.0)
    assert coverage.worst(20.0) == pytest.approx(20.0, abs=1.0)


def test_robot_off_the_border_visits_no_point() -> None:
    coverage = Coverage(LINE, 0.0)
    coverage.visit([(5.0, 0.3), (math.inf, 0.0)], 1.0)
    assert not coverage.seen().any()


def test_worst_idleness_includes_past_ones() -> None:
    coverage = Coverage(LINE, 0.0)
    coverage.visit([(5.0, 0.0)], 30.0)
    for t in range(31, 60):
        coverage.visit([(x, 0.0) for x in np.arange(0.0, 10.1, 0.25)], float(t))
    assert coverage.worst(60.0) == pytest.approx(31.0)

from __future__ import annotations

import numpy as np
import pytest

from drivers.p2os.model import load_model
from drivers.p2os.sonar import SonarRing

FAR_AS_REPORTED = 18657 * 0.000268


def test_ring_without_readings_has_no_points() -> None:
    ring = SonarRing(load_model("p2dx"))
    assert ring.points(0.0, 10.0).shape == (0, 2)
    assert np.all(np.isinf(ring.ages(0.0)))


def test_points_lie_along_the_transducers() -> None:
    ring = SonarRing(load_model("p2dx"))
    ring.update(1.0, [(0, 1.0), (3, 2.0), (12, 0.5)])
    angle = np.radians(10.0)
    expected = [
        (0.069, 1.136),
        (0.166 + 2.0 * np.cos(angle), 0.027 + 2.0 * np.sin(angle)),
        (-0.255 - 0.5 * np.cos(angle), 0.027 + 0.5 * np.sin(angle)),
    ]
    assert ring.points(1.0, 0.5) == pytest.approx(np.array(expected))


def test_old_and_far_readings_are_left_out() -> None:
    ring = SonarRing(load_model("p2dx"))
    ring.update(1.0, [(0, 1.0)])
    ring.update(1.4, [(7, 1.0), (8, FAR_AS_REPORTED), (9, 4.9)])
    assert len(ring.points(1.4, 0.5)) == 3
    assert len(ring.points(1.6, 0.5)) == 2
    assert len(ring.points(2.0, 0.5)) == 0
    assert ring.ages(1.6)[[0, 7]] == pytest.approx([0.6, 0.2])


def test_latest_reading_is_kept_and_unknown_numbers_are_ignored() -> None:
    ring = SonarRing(load_model("p2dx"))
    ring.update(0.0, [(0, 1.0), (0, 2.0), (16, 1.0), (31, 1.0)])
    assert ring.points(0.0, 1.0) == pytest.approx(np.array([(0.069, 2.136)]))

from __future__ import annotations

import numpy as np

from tools.calibration.own_parts import own_sectors

ANGLES = np.radians(np.arange(-90.0, 91.0))


def test_near_returns_that_never_change_are_own_parts() -> None:
    rng = np.random.default_rng(1)
    ranges = rng.uniform(0.3, 8.0, (200, 181))  # a drive: everything changes
    ranges[:, 20:24] = 0.35 + rng.normal(0.0, 0.01, (200, 4))  # a mast
    ranges[:60, 22] = np.inf
    ranges[:, 100] = 5.0  # a wall followed at one distance
    assert own_sectors(ANGLES, ranges) == [(19.0, 24.0)]


def test_a_drive_without_beams_has_no_own_parts() -> None:
    assert own_sectors(np.empty(0), np.empty((0, 0))) == []


def test_own_parts_behind_are_in_the_degrees_of_a_wide_scanner() -> None:
    rng = np.random.default_rng(1)
    ranges = rng.uniform(0.3, 8.0, (200, 541))
    ranges[:, :9] = 0.3 + rng.normal(0.0, 0.01, (200, 9))  # a bracket, up to the end of the view
    assert own_sectors(np.radians(np.linspace(-135.0, 135.0, 541)), ranges) == [(-45.0, -40.0)]

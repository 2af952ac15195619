"""What means "no return" in a log: codes of the scanner's mode, a pile-up, or what one is told."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from tools.logs.no_return import no_return

SCANS = 60


def hall(reach: float, written: float, decimals: int = 2) -> list[NDArray[np.float64]]:
    """Return scans of 180 beams up to 38 m, those beyond reach replaced by what is written."""
    rng = np.random.default_rng(5)
    scans = []
    for _ in range(SCANS):
        ranges = 1.0 + 37.0 * rng.random(180) ** 2
        scans.append(np.round(np.where(ranges > reach, written, ranges), decimals))
    return scans


@pytest.mark.parametrize(
    ("reach", "written"),
    [(8.19, 8.191), (8.18, 8.183), (32.0, 32.77), (32.7, 32.767), (16.3, 16.383), (80.0, 81.91)],
)
def test_codes_of_each_mode_of_an_lms_200_mean_no_return(reach: float, written: float) -> None:
    for decimals in (2, 3):
        scans = hall(reach, written, decimals)
        scans[3][7] = round(written, decimals)
        limit = no_return(scans).limit
        assert 0.99 * reach < limit <= round(written, decimals)


@pytest.mark.parametrize("written", [51.2, 50.0, 30.0, 20.0, 65.533])
def test_pile_up_at_the_largest_reading_means_no_return(written: float) -> None:
    found = no_return(hall(min(written, 25.0) - 0.5, written))
    assert 0.99 * written < found.limit < written
    assert "pile up" in found.reason


def test_second_pile_up_below_the_scanners_codes_is_found_too() -> None:
    scans = hall(20.0, 50.0)
    scans[0][:3] = 81.91
    assert 49.9 < no_return(scans).limit < 50.0


def test_log_without_no_return_keeps_all_its_readings() -> None:
    scans = hall(40.0, 99.0)
    assert no_return(scans).limit == 80.0


def test_wall_before_a_robot_that_stands_is_no_pile_up() -> None:
    assert no_return([np.full(180, 2.0)] * SCANS).limit == 80.0


def test_limit_that_one_is_told_wins() -> None:
    assert no_return(hall(8.19, 8.191), 12.5).limit == 12.5


def test_log_without_readings_has_the_scanners_reach() -> None:
    assert no_return([]).limit == 80.0
    assert no_return([np.array([0.0, np.nan])]).limit == 80.0

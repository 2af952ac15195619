from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from drivers.lms1xx.measurement import Channel, Measurement
from drivers.lms1xx.scan import scan_of
from drivers.scan import Special


def channel(counts: list[int], content: str = "DIST1", scale: float = 1.0) -> Channel:
    return Channel(content, scale, 0.0, -450000, 5000, np.array(counts, dtype=np.uint16))


def measurement(*wide: Channel) -> Measurement:
    return Measurement(1, 0, 0, 0, 1000, 4000, 5000, wide)


def test_small_counts_are_no_ranges() -> None:
    scan = scan_of(measurement(channel([0, 1, 2, 15, 16, 20000])), 1.0)
    assert scan is not None
    assert scan.ranges.tolist() == [np.inf] * 4 + [0.016, 20.0]
    kinds = (Special.NO_RETURN, Special.DAZZLED, Special.READ_ERROR, Special.READ_ERROR)
    assert scan.specials.tolist() == [*kinds, Special.RANGE, Special.RANGE]


def test_scale_and_offset_give_millimetres() -> None:
    scaled = replace(channel([1000, 60000], scale=2.0), offset=-500.0)
    scan = scan_of(measurement(scaled), 1.0)
    assert scan is not None
    assert scan.ranges.tolist() == [pytest.approx(1.5), np.inf]
    assert scan.specials[1] == Special.BEYOND_MAXIMUM


@pytest.mark.parametrize("scale", [np.nan, np.inf, -np.inf])
def test_a_scale_that_is_no_number_gives_no_scan(scale: float) -> None:
    assert scan_of(measurement(channel([100, 100], scale=scale)), 1.0) is None


@pytest.mark.parametrize("counts", [[], [100]])
def test_a_scan_of_less_than_two_beams_is_none(counts: list[int]) -> None:
    assert scan_of(measurement(channel(counts)), 1.0) is None


def test_the_second_echo_alone_is_no_scan() -> None:
    assert scan_of(measurement(channel([100, 100], "DIST2")), 1.0) is None
    both = measurement(channel([100, 100]), channel([200, 200], "DIST2"))
    scan = scan_of(both, 1.0)
    assert scan is not None
    assert scan.ranges.tolist() == [0.1, 0.1]


@pytest.mark.parametrize("frequency", [0, 1 << 31])
def test_any_frequency_gives_a_finite_time_or_none(frequency: int) -> None:
    scan = scan_of(replace(measurement(channel([100, 100])), frequency=frequency), 1.0)
    assert scan is None or np.isfinite(scan.t)


def test_the_scanners_clock_may_start_again_between_mark_and_sending() -> None:
    wrapped = replace(measurement(channel([100] * 541)), counted=(1 << 32) - 1000, sent=2000)
    scan = scan_of(wrapped, 1.0)
    assert scan is not None
    assert 1.0 - scan.t == pytest.approx(0.003 + 0.0075)

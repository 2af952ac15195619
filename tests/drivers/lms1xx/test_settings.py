from __future__ import annotations

import math

import pytest

from drivers.lms1xx.settings import LaserSettings
from drivers.lms1xx.telegrams import OutputRange, Scanning


def test_the_output_range_is_centred_ahead() -> None:
    assert LaserSettings().output_range == OutputRange(5000, -450000, 2250000)
    narrow = LaserSettings(field_of_view_deg=190.0, resolution_deg=0.1667)
    assert narrow.output_range == OutputRange(1667, -50000, 1850000)


def test_the_sector_of_the_scanner_stays_as_it_is() -> None:
    present = Scanning(2500, 2500, -50000, 1850000)
    assert LaserSettings().scanning(present) == Scanning(5000, 5000, -50000, 1850000)


def test_by_request_scans_are_as_far_apart_as_the_questions() -> None:
    assert LaserSettings().scan_period == pytest.approx(0.02)
    assert LaserSettings(by_request=True).scan_period == pytest.approx(0.05)
    assert LaserSettings(by_request=True, frequency=15.0).scan_period == pytest.approx(1 / 15)


@pytest.mark.parametrize("upside_down", [False, True])
def test_sectors_reach_behind_in_its_own_degrees(*, upside_down: bool) -> None:
    settings = LaserSettings(ignore=((-45.0, 0.0),), upside_down=upside_down)
    expected = (-135.0, -90.0) if not upside_down else (90.0, 135.0)
    assert settings.ignored == (pytest.approx(tuple(map(math.radians, expected))),)
    assert settings.degrees_of(settings.ignored) == [[-45, 0]]


@pytest.mark.parametrize("sector", [(-46.0, 0.0), (200.0, 226.0), (10.0, 10.0)])
def test_sectors_outside_the_view_are_refused(sector: tuple[float, float]) -> None:
    with pytest.raises(ValueError, match="-45 to 225 degrees"):
        LaserSettings(ignore=(sector,))


def test_the_models_mounting_counts_where_nothing_is_said() -> None:
    settings = LaserSettings(ignore=((0.0, 10.0),)).mounted(
        upside_down=True, ignore=((170.0, 180.0),)
    )
    assert settings.upside_down
    assert settings.ignore == ((170.0, 180.0), (0.0, 10.0))

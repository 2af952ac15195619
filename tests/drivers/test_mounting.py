"""A scan of a scanner upside down, and of one that sees its own robot."""

import math

import numpy as np
import pytest

from drivers.lms200.framing import Telegram
from drivers.lms200.measurement import MEASURING_MODES, UNIT_MM, decode_measurement
from drivers.lms200.scan import scan_of
from drivers.lms200.settings import LaserSettings
from drivers.mounting import as_mounted
from drivers.scan import Scan, Special, beam_time_offsets
from tests.drivers.lms200.measured_telegram import encode_measurement as encode

MODE = MEASURING_MODES[5]


def scan(ranges: np.ndarray) -> Scan:
    measurement = decode_measurement(Telegram(0x80, encode(ranges, MODE, UNIT_MM)), MODE)
    assert measurement is not None
    return scan_of(measurement, 10.0, 0.1)


def offsets(of: Scan) -> np.ndarray:
    return beam_time_offsets(
        of.ranges.size, of.angle_min, of.angle_increment, of.turns, of.turn_time, of.clockwise
    )


def test_upright_scanner_without_ignored_sectors_is_left_alone() -> None:
    measured = scan(np.ones(181))
    assert as_mounted(measured, LaserSettings()) is measured


def test_upside_down_the_first_beam_is_the_leftmost() -> None:
    measured = scan(np.linspace(1.0, 2.0, 181))
    turned = as_mounted(measured, LaserSettings(upside_down=True))
    assert turned.ranges[0] == measured.ranges[180]
    assert turned.angles == pytest.approx(measured.angles)


@pytest.mark.parametrize("count", [181, 361])
def test_upside_down_each_beam_keeps_its_time(count: int) -> None:
    measured = scan(np.ones(count))
    turned = as_mounted(measured, LaserSettings(upside_down=True, resolution_deg=0.5))
    assert offsets(turned)[::-1] == pytest.approx(offsets(measured))


def test_beams_of_ignored_sectors_have_no_range() -> None:
    left = as_mounted(scan(np.ones(181)), LaserSettings(ignore=((0.0, 2.0), (170.0, 171.0))))
    assert np.flatnonzero(np.isinf(left.ranges)).tolist() == [0, 1, 2, 170, 171]
    assert (left.specials[np.isinf(left.ranges)] == Special.IGNORED).all()


def test_sectors_of_the_laser_frame_are_named_in_the_degrees_of_the_scanner() -> None:
    sectors = ((math.radians(-89.5), math.radians(-80.0)), (math.radians(10.2), math.radians(20.7)))
    upright, turned_over = LaserSettings(), LaserSettings(upside_down=True)
    assert upright.degrees_of(sectors) == [[0, 10], [100, 111]]
    assert turned_over.degrees_of(sectors) == [[69, 80], [170, 180]]


def test_ignored_sectors_are_in_the_degrees_of_the_scanner_also_upside_down() -> None:
    settings = LaserSettings(upside_down=True, ignore=((0.0, 2.0),))
    turned = as_mounted(scan(np.ones(181)), settings)
    assert np.flatnonzero(np.isinf(turned.ranges)).tolist() == [178, 179, 180]
    assert settings.ignored[0] == pytest.approx((math.radians(88.0), math.pi / 2))


@pytest.mark.parametrize("sector", [(10.0, 5.0), (-3.0, 4.0), (170.0, 190.0)])
def test_a_sector_the_scanner_does_not_have_is_refused(sector: tuple[float, float]) -> None:
    with pytest.raises(ValueError, match="ignore has"):
        LaserSettings(ignore=(sector,))


@pytest.mark.parametrize("over", [False, True])
def test_upside_down_is_the_models_unless_it_is_set(over: bool) -> None:
    assert LaserSettings().mounted(upside_down=over).upside_down is over
    assert LaserSettings(upside_down=not over).mounted(upside_down=over).upside_down is not over


def test_sectors_of_the_model_are_ignored_beside_those_that_are_set() -> None:
    settings = LaserSettings(ignore=((10.0, 20.0),)).mounted(
        upside_down=True, ignore=((160.0, 170.0),)
    )
    assert settings.ignore == ((160.0, 170.0), (10.0, 20.0))
    assert len(settings.ignored) == 2

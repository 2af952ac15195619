"""The session with means, sub-ranges, reflectivity and interlaced quarters of a degree."""

from __future__ import annotations

import math
from typing import Any

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from drivers.lms200.emulator.emulator import Lms200Emulator
from drivers.lms200.framing import Telegram
from drivers.lms200.measured_parts import OUTPUT_CODES, decode_output
from drivers.lms200.measurement import MEASURING_MODES, TURN
from drivers.lms200.session import Lms200Session, SessionState
from drivers.lms200.settings import LaserSettings
from drivers.lms200.telegrams import VARIANTS, Variant

AHEAD_ONLY = (45, 135)


class Slope:
    """Ranges that fall from right to left by a metre a radian, reflecting left of 45 degrees."""

    def __init__(self) -> None:
        self.asked: list[float] = []
        self.angles = np.empty(0)

    def __call__(self, t: float, n: int, increment: float) -> NDArray[np.float64]:
        self.asked.append(t)
        self.angles = (np.arange(n) - (n - 1) / 2) * increment
        return slope(self.angles)

    def reflectors(self) -> NDArray[np.bool_]:
        return self.angles > math.radians(45.5)


def slope(angles: NDArray[np.float64]) -> NDArray[np.float64]:
    return 4.0 - angles


def streaming(line: Any, scene: Slope, **settings: object) -> Any:
    emulator = Lms200Emulator(scan_source=scene, reflector_source=scene.reflectors)
    wire = line(Lms200Session(msgspec.convert(settings, LaserSettings)), emulator)
    wire.connect()
    wire.run_until(SessionState.STREAMING, limit=12.0)
    wire.run(4.0)
    assert wire.session.trouble is None
    assert wire.session.counters.unusable == 0
    return wire


def check_period(wire: Any, settings: LaserSettings) -> None:
    times = [scan.t for scan in wire.scans]
    assert np.diff(times).mean() == pytest.approx(settings.scan_period, rel=0.02)


@pytest.mark.parametrize("resolution_deg", [1.0, 0.5])
@pytest.mark.parametrize("sector", [None, AHEAD_ONLY])
@pytest.mark.parametrize("mean_of", [1, 4])
def test_means_and_sub_ranges_have_the_angles_and_times_of_their_beams(
    line: Any, resolution_deg: float, sector: tuple[int, int] | None, mean_of: int
) -> None:
    scene = Slope()
    output = {"resolution_deg": resolution_deg, "sector": sector, "mean_of": mean_of}
    wire = streaming(line, scene, **output)
    scan = wire.scans[-1]
    first, last = sector or (0, 180)
    assert scan.ranges.size == round((last - first) / resolution_deg) + 1
    assert scan.angles[0] == pytest.approx(math.radians(first - 90))
    assert scan.angles[-1] == pytest.approx(math.radians(last - 90))
    np.testing.assert_allclose(scan.ranges, slope(scan.angles), atol=0.00051)
    check_period(wire, msgspec.convert(output, LaserSettings))
    turns = round(1 / resolution_deg) * mean_of
    measured = np.reshape(scene.asked[: turns * len(wire.scans)], (-1, turns)).mean(axis=1)
    np.testing.assert_allclose([scan.t for scan in wire.scans], measured, atol=1e-4)
    assert scan.turns == round(1 / resolution_deg)


def test_remission_comes_with_each_range(line: Any) -> None:
    wire = streaming(line, Slope(), remission=True, baud=500000)
    scan = wire.scans[-1]
    assert scan.ranges.size == 181
    np.testing.assert_allclose(scan.ranges, slope(scan.angles), atol=0.00051)
    assert scan.remission is not None
    assert set(scan.remission[:136]) == {1950}
    assert set(scan.remission[136:]) == {13000}


def test_remission_of_a_scanner_upside_down_is_turned_over_too(line: Any) -> None:
    wire = streaming(line, Slope(), remission=True, upside_down=True)
    scan = wire.scans[-1]
    assert scan.remission is not None
    assert set(scan.remission[45:]) == {1950}
    assert set(scan.remission[:45]) == {13000}


def test_quarters_of_a_degree_come_as_partial_scans_of_180_degrees(line: Any) -> None:
    wire = streaming(line, Slope(), partial_scans=True, resolution_deg=0.25, baud=500000)
    offsets = {}
    for scan in wire.scans[4:]:
        np.testing.assert_allclose(scan.ranges, slope(scan.angles), atol=0.00051)
        offsets[round(math.degrees(scan.angle_min) + 90, 3)] = scan.ranges.size
        assert scan.angle_increment == pytest.approx(math.radians(1.0))
    assert offsets == {0.0: 181, 0.25: 180, 0.5: 180, 0.75: 180}
    assert np.diff([scan.t for scan in wire.scans]).mean() == pytest.approx(TURN, rel=0.02)


def test_sub_range_of_a_laser_that_keeps_another_variant_has_its_angles(line: Any) -> None:
    class Fixed(Lms200Emulator):
        def feed(self, data: bytes, t: float) -> None:
            super().feed(data, t)
            self.state.variant = Variant(180, 50)

    emulator = Fixed(scan_source=Slope(), baud=38400)
    settings = LaserSettings(sector=AHEAD_ONLY)
    wire = line(Lms200Session(settings), emulator)
    wire.connect()
    for _ in range(3):
        wire.run(3.0)
        emulator.power_on(wire.t)
    wire.scans.clear()
    wire.run(4.0)
    assert wire.session.trouble == "laser does not keep its field of view and step"
    np.testing.assert_allclose(wire.scans[-1].ranges, slope(wire.scans[-1].angles), atol=0.00051)


@pytest.mark.parametrize(
    ("given_settings", "words"),
    [
        ({"resolution_deg": 0.25}, "with partial_scans"),
        ({"partial_scans": True, "mean_of": 2}, "without mean_of"),
        ({"partial_scans": True, "sector": (10, 20)}, "without mean_of, sector"),
        ({"remission": True, "resolution_deg": 0.5}, "resolution_deg of 1.0"),
        ({"remission": True, "mean_of": 2}, "without mean_of"),
        ({"sector": (20, 20)}, "0 to 180 degrees"),
        ({"sector": (20, 120), "field_of_view_deg": 100}, "40 to 140 degrees"),
        ({"mean_of": 251}, "<= 250"),
        ({"mean_of": 200}, "silence must be longer"),
    ],
)
def test_outputs_that_no_laser_has_are_refused(
    given_settings: dict[str, object], words: str
) -> None:
    with pytest.raises(msgspec.ValidationError, match=words):
        msgspec.convert(given_settings, LaserSettings)


@given(
    st.sampled_from(sorted(OUTPUT_CODES)),
    st.binary(max_size=807),
    st.sampled_from(VARIANTS),
    st.sampled_from(sorted(MEASURING_MODES)),
)
def test_any_payload_is_decoded_or_none(
    code: int, data: bytes, variant: Variant, mode: int
) -> None:
    telegram = Telegram(0x80, bytes((code,)) + data)
    measurement = decode_output(telegram, MEASURING_MODES[mode], variant)
    assert measurement is None or not np.isnan(measurement.ranges).any()


@pytest.mark.parametrize(
    "payload",
    [
        "B7 01 00 02 00 02 40 E8 03 E8 03 10",
        "BF 05 01 00 02 00 02 40 E8 03 E8 03 10",
        "F5 01 00 01 00 02 00 02 40 E8 03 00 01 E8 03 00 02 07 08 10",
    ],
)
def test_length_and_ends_must_fit(payload: str) -> None:
    good = bytes.fromhex(payload)
    place = 3 if good[0] == 0xB7 else 4 if good[0] == 0xBF else 5
    longer_part = good[:place] + b"\x03" + good[place + 1 :]
    mode = MEASURING_MODES[0x0E]
    assert decode_output(Telegram(0x80, good), mode, VARIANTS[0]) is not None
    for bad in (good[:-3], good + b"\0", longer_part):
        assert decode_output(Telegram(0x80, bad), mode, VARIANTS[0]) is None

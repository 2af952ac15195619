"""Measured values: counts, units, value bits, special values, the geometry and time of a scan."""

from __future__ import annotations

import math
import struct
import timeit

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.lms200.framing import Telegram, TelegramFramer, encode_telegram
from drivers.lms200.measurement import (
    MEASURING_MODES,
    UNIT_CM,
    UNIT_MM,
    decode_measurement,
)
from drivers.lms200.scan import scan_of
from tests.drivers.lms200.measured_telegram import encode_measurement

MODE_32 = MEASURING_MODES[5]


def telegram(values: list[int], flags: int = 0x4000, tail: bytes = b"\x10") -> Telegram:
    head = struct.pack("<BH", 0xB0, len(values) | flags)
    return Telegram(0x80, head + struct.pack(f"<{len(values)}H", *values) + tail)


@pytest.mark.parametrize(
    ("count", "first_deg", "step_deg", "turns"),
    [
        (181, 0.0, 1.0, 1),
        (361, 0.0, 0.5, 2),
        (101, 40.0, 1.0, 1),
        (201, 40.0, 0.5, 2),
        (401, 40.0, 0.25, 4),
    ],
)
def test_each_count_has_its_geometry(
    count: int, first_deg: float, step_deg: float, turns: int
) -> None:
    measurement = decode_measurement(telegram([1000] * count), MODE_32)
    assert measurement is not None
    assert measurement.ranges.shape == (count,)
    assert (measurement.first_deg, measurement.step_deg) == (first_deg, step_deg)
    assert measurement.mirror_turns == turns
    last = first_deg + step_deg * (count - 1)
    assert last == 180.0 - first_deg


@pytest.mark.parametrize(("quarter", "first_deg"), [(0, 0.0), (1, 0.25), (2, 0.5), (3, 0.75)])
def test_partial_scans_start_at_their_quarter_degree(quarter: int, first_deg: float) -> None:
    count = 181 if quarter == 0 else 180
    flags = 0x4000 | 0x2000 | quarter << 11
    measurement = decode_measurement(telegram([1000] * count, flags), MODE_32)
    assert measurement is not None
    assert (measurement.first_deg, measurement.step_deg) == (first_deg, 1.0)


@pytest.mark.parametrize(("flags", "metres"), [(0x0000, 10.0), (0x4000, 1.0), (0x8000, 100.0)])
def test_units_scale_the_ranges(flags: int, metres: float) -> None:
    measurement = decode_measurement(telegram([1000] * 181, flags), MODE_32)
    assert measurement is not None
    np.testing.assert_allclose(measurement.ranges, metres)


@pytest.mark.parametrize(
    ("code", "flag_bits", "first_special"),
    [
        (0x00, 0xE000, 0x1FF7),
        (0x01, 0xE000, 0x1FF7),
        (0x02, 0xE000, 0x1FF7),
        (0x03, 0xC000, 0x3FF7),
        (0x04, 0xC000, 0x3FF7),
        (0x05, 0x8000, 0x7FF7),
        (0x06, 0x8000, 0x7FF7),
        (0x0F, 0x0000, 0x7FF7),
    ],
)
def test_value_bits_and_special_values_are_decoded(
    code: int, flag_bits: int, first_special: int
) -> None:
    values = [1500] * 181
    values[0] = first_special - 1
    values[1:10] = [first_special + step for step in range(9)]
    flagged = [value | flag_bits for value in values]
    measurement = decode_measurement(telegram(flagged), MEASURING_MODES[code])
    assert measurement is not None
    assert measurement.ranges[0] == pytest.approx((first_special - 1) / 1000)
    assert np.isinf(measurement.ranges[1:10]).all()
    np.testing.assert_allclose(measurement.ranges[10:], 1.5)


@pytest.mark.parametrize(
    "bad",
    [
        telegram([1000] * 180),
        telegram([1000] * 181, flags=0xC000),
        telegram([1000] * 181, tail=b"\x00\x10"),
        telegram([1000] * 181, tail=b""),
        telegram([1000, 2500, 8191]),
        Telegram(0x80, b"\xb0"),
        Telegram(0x80, b"\xa0\x00\x10\x00\x00"),
    ],
)
def test_incomplete_scan_is_none(bad: Telegram) -> None:
    assert decode_measurement(bad, MODE_32) is None


def test_scan_and_telegram_indices_are_skipped() -> None:
    measurement = decode_measurement(telegram([1000] * 181, tail=b"\x07\x08\x11"), MODE_32)
    assert measurement is not None
    assert measurement.status == 0x11
    np.testing.assert_allclose(measurement.ranges, 1.0)


def test_documented_frames_decode_to_one_metre() -> None:
    mode = MEASURING_MODES[5]
    for count, head, end in [(181, "B0 B5 40", "10 95 6D"), (361, "B0 69 41", "10 55 F1")]:
        payload = encode_measurement(np.full(count, 1.0), mode, UNIT_MM)
        frame = encode_telegram(payload, 0x80)
        assert frame[4:7] == bytes.fromhex(head)
        assert frame[-3:] == bytes.fromhex(end)


@given(
    st.sampled_from(sorted(MEASURING_MODES)),
    st.sampled_from([UNIT_CM, UNIT_MM]),
    st.lists(st.floats(0.0, 100.0), min_size=181, max_size=181),
)
def test_round_trip_is_exact_to_the_unit(code: int, units: int, values: list[float]) -> None:
    mode, ranges = MEASURING_MODES[code], np.array(values)
    payload = encode_measurement(ranges, mode, units)
    measurement = decode_measurement(Telegram(0x80, payload), mode)
    assert measurement is not None
    unit = 0.001 if units == UNIT_MM else 0.01
    representable = np.rint(ranges / unit) < mode.limit
    expected = np.where(representable, ranges, np.inf)
    np.testing.assert_allclose(measurement.ranges, expected, atol=unit * 0.501)


def test_no_return_is_the_documented_special_value() -> None:
    ranges = np.full(181, np.inf)
    ranges[1] = np.nan
    ranges[2] = 50.0
    payload = encode_measurement(ranges, MODE_32, UNIT_MM)
    assert struct.unpack_from("<3H", payload, 3) == (32767, 32767, 32759)


@given(st.binary(min_size=1, max_size=808))
def test_any_payload_is_decoded_or_none(payload: bytes) -> None:
    measurement = decode_measurement(Telegram(0x80, b"\xb0" + payload), MODE_32)
    assert measurement is None or not np.isnan(measurement.ranges).any()


@pytest.mark.parametrize(("count", "before_sending"), [(181, 6.66e-3), (361, 13.32e-3)])
def test_scan_time_is_the_middle_of_its_sweep(count: int, before_sending: float) -> None:
    measurement = decode_measurement(telegram([1000] * count), MODE_32)
    assert measurement is not None
    scan = scan_of(measurement, arrival=10.0, wire_time=0.1)
    assert scan.t == pytest.approx(10.0 - 0.1 - before_sending)


def test_first_beam_is_the_rightmost() -> None:
    measurement = decode_measurement(telegram([1000] * 181), MODE_32)
    assert measurement is not None
    scan = scan_of(measurement, 0.0, 0.0)
    assert scan.angles[0] == pytest.approx(-math.pi / 2)
    assert scan.angles[90] == pytest.approx(0.0)
    assert scan.angles[180] == pytest.approx(math.pi / 2)


def test_whole_scan_is_decoded_fast() -> None:
    frame = encode_telegram(telegram([1000] * 181).payload, 0x80)
    framer = TelegramFramer()

    def decode() -> None:
        (found,) = framer.feed(frame)
        assert isinstance(found, Telegram)
        assert decode_measurement(found, MODE_32) is not None

    seconds = min(timeit.repeat(decode, number=50, repeat=5)) / 50
    assert seconds < 2e-3  # measured: some 15 us


@pytest.mark.parametrize("code", sorted(MEASURING_MODES))
def test_reflectors_are_sent_in_the_modes_that_report_them(code: int) -> None:
    mode, reflectors = MEASURING_MODES[code], np.zeros(181, dtype=np.bool_)
    reflectors[[3, 90]] = True
    ranges = np.full(181, 2.0)
    ranges[3] = np.inf
    payload = encode_measurement(ranges, mode, UNIT_MM, reflectors=reflectors)
    measurement = decode_measurement(Telegram(0x80, payload), mode)
    assert measurement is not None
    np.testing.assert_allclose(measurement.ranges, ranges)
    if mode.reflector_bits:
        assert measurement.reflectors is not None
        assert measurement.reflectors.nonzero()[0].tolist() == [90]
    else:
        assert measurement.reflectors is None
        assert not measurement.flags.any()

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from drivers.lms200.framing import Telegram
from drivers.lms200.measurement import MEASURING_MODES, TURN, UNIT_MM, decode_measurement
from drivers.lms200.scan import scan_of
from drivers.scan import Scan, Special, beam_time_offsets
from tests.drivers.lms200.measured_telegram import encode_measurement as encode

MODE = MEASURING_MODES[5]


def scan(payload: bytes, arrival: float = 10.0, wire_time: float = 0.1) -> Scan:
    measurement = decode_measurement(Telegram(0x80, payload), MODE)
    assert measurement is not None
    return scan_of(measurement, arrival, wire_time)


def beam_times(whole: Scan) -> NDArray[np.float64]:
    geometry = (whole.ranges.size, whole.angle_min, whole.angle_increment, whole.turns, TURN)
    return whole.t + beam_time_offsets(*geometry)


def test_time_offsets_of_one_turn_span_half_a_turn() -> None:
    whole = scan(encode(np.ones(181), MODE, UNIT_MM))
    times = beam_times(whole)
    assert whole.t == pytest.approx(10.0 - 0.1 - TURN / 2)
    assert times[90] == pytest.approx(whole.t)
    assert times[-1] - times[0] == pytest.approx(TURN / 2)
    assert (np.diff(times) > 0).all()


def test_halves_of_an_interlaced_scan_are_a_turn_apart() -> None:
    whole = scan(encode(np.ones(361), MODE, UNIT_MM))
    assert whole.turns == 2
    times = beam_times(whole)
    even, odd = times[0::2], times[1::2]
    assert (np.diff(even) > 0).all()
    between = 0.5 * (even[:-1] + even[1:])
    assert odd - between == pytest.approx(TURN)
    assert 0.5 * (times[180] + times[179:182:2].mean()) == pytest.approx(whole.t)
    assert times.max() <= 10.0 - 0.1


def test_offsets_are_cached_and_read_only() -> None:
    offsets = beam_time_offsets(181, -math.pi / 2, math.pi / 180, 1, TURN)
    assert offsets is beam_time_offsets(181, -math.pi / 2, math.pi / 180, 1, TURN)
    with pytest.raises(ValueError, match="read-only"):
        offsets[0] = 1.0


@pytest.mark.parametrize(
    ("value", "special"),
    [
        (32766, Special.DAZZLED),
        (32765, Special.OVERFLOW),
        (32763, Special.LOW_SIGNAL),
        (32762, Special.READ_ERROR),
        (32759, Special.BEYOND_MAXIMUM),
        (32767, Special.NO_RETURN),
    ],
)
def test_special_values_are_separate_from_ranges(value: int, special: Special) -> None:
    values = np.full(181, 1000, "<u2")
    values[[3, 5]] = value
    values[7] = 0x8000 | 2000  # the mode's reflector bit
    payload = b"\xb0" + (181 | 0x4000).to_bytes(2, "little") + values.tobytes() + b"\x10"
    seen = scan(payload)
    assert np.isinf(seen.ranges[[3, 5]]).all()
    assert seen.ranges[7] == 2.0
    assert np.isfinite(np.delete(seen.ranges, [3, 5])).all()
    assert (seen.specials == special).sum() == 2
    assert seen.reflectors is not None
    assert seen.reflectors.nonzero()[0].tolist() == [7]

"""The content of the telegrams of measured values, by their layout."""

from __future__ import annotations

import struct

import numpy as np
import pytest
from numpy.typing import NDArray

from drivers.lms200.emulator.emulator import Lms200Emulator
from drivers.lms200.emulator.mirror import TURN
from drivers.lms200.framing import Telegram, TelegramFramer, encode_telegram
from drivers.lms200.telegrams import Configuration, Variant

INDICES = Configuration(bytes.fromhex("0000460002 00 01"))


def ramp(t: float, n: int, increment: float) -> NDArray[np.float64]:
    """1 m at the right, a millimetre more with each beam."""
    return 1.0 + 0.001 * np.arange(n)


class Alternating:
    """3 m and 4 m in turn."""

    def __init__(self) -> None:
        self.turns = 0

    def __call__(self, t: float, n: int, increment: float) -> NDArray[np.float64]:
        self.turns += 1
        return np.full(n, 3.0 + self.turns % 2)


def asked(
    emulator: Lms200Emulator, command: str, t: float = 0.0, until: float = 2.0
) -> list[bytes]:
    """Return the payloads that come after a mode's reply, or all after a request."""
    emulator.feed(encode_telegram(bytes.fromhex(command)), t)
    framer = TelegramFramer()
    found = framer.feed(b"".join(item.data for item in emulator.pop_output(t + until)))
    payloads = [item.payload for item in found if isinstance(item, Telegram)]
    return [payload for payload in payloads if payload[0] != 0xA0]


def laser(variant: Variant, source: object = ramp) -> Lms200Emulator:
    return Lms200Emulator(baud=500000, scan_source=source, variant=variant)  # type: ignore[arg-type]


def words(payload: bytes, at: int, count: int) -> list[int]:
    return list(struct.unpack_from(f"<{count}H", payload, at))


def test_sub_range_has_the_values_of_its_beams() -> None:
    (payload,) = asked(laser(Variant(180, 50)), "37 0B 00 0E 00")
    assert words(payload, 1, 3) == [11, 14, 4 | 1 << 14]
    assert words(payload, 7, 4) == [1010, 1011, 1012, 1013]


def test_mean_is_of_as_many_scans_and_comes_as_seldom() -> None:
    emulator = laser(Variant(180, 100), Alternating())
    means = asked(emulator, "20 26 04", until=1.0)
    assert {payload[:2] for payload in means} == {b"\xb6\x04"}
    assert set(words(means[0], 4, 181)) == {3500}
    assert len(means) == pytest.approx(1.0 / (4 * TURN), abs=1.5)


def test_reflectivity_parts_are_pairs() -> None:
    reflecting = np.zeros(181, dtype=np.bool_)
    reflecting[5] = True
    emulator = Lms200Emulator(
        baud=500000,
        scan_source=ramp,
        reflector_source=lambda: reflecting,
        variant=Variant(180, 100),
    )
    (payload,) = asked(emulator, "75 02 00 05 00 06 00 B5 00 B5 00")
    assert words(payload, 1, 4) == [2, 5, 6, 2 | 1 << 14]
    assert words(payload, 9, 4) == [1004, 1950, 1005, 13000]
    assert words(payload, 17, 5) == [181, 181, 1 | 1 << 14, 1180, 1950]


def test_all_ranges_come_with_the_reflectivity_of_a_part() -> None:
    (payload,) = asked(laser(Variant(180, 100)), "44 02 00 04 00")
    assert words(payload, 1, 2) == [181 | 1 << 14, 1000]
    assert words(payload, 3 + 362, 3) == [3, 2, 4]
    assert payload[3 + 362 + 6 : -1] == bytes((38, 38, 38))


def test_reflectivity_mode_sends_it_in_place_of_ranges() -> None:
    emulator = laser(Variant(180, 100))
    emulator.state.configuration = emulator.state.configuration.changed(0x3F, 1)
    (payload,) = asked(emulator, "30 01")
    assert set(words(payload, 3, 181)) == {1950}


def test_segments_of_a_degree_and_every_so_many_values() -> None:
    emulator = laser(Variant(180, 50))
    (minima,) = asked(emulator, "30 02")
    assert words(minima, 1, 3) == [181 | 1 << 14, 1000, 1002]
    (second,) = asked(emulator, "30 06", 3.0)
    assert words(second, 1, 3) == [181 | 1 << 14, 1000, 1002]
    (twentieth,) = asked(emulator, "30 07", 6.0)
    assert words(twentieth, 1, 3) == [19 | 1 << 14, 1000, 1020]


@pytest.mark.parametrize("variant", [Variant(100, 25), Variant(180, 50), Variant(100, 50)])
def test_partial_scans_cover_180_degrees_whatever_the_variant(variant: Variant) -> None:
    offsets: dict[int, tuple[int, int]] = {}
    for payload in asked(laser(variant), "20 2A", until=0.3):
        (word,) = words(payload, 1, 1)
        assert word & 0x2000
        offsets[word >> 11 & 3] = (word & 0x3FF, words(payload, 3, 1)[0])
    step = variant.resolution_cdeg // 25
    assert offsets == {
        turn * step: (180 if turn else 181, 1000 + turn) for turn in range(variant.mirror_turns)
    }


@pytest.mark.parametrize(("variant", "turns"), [(Variant(180, 100), 1), (Variant(180, 50), 2)])
def test_scan_index_counts_mirror_turns_and_telegram_index_telegrams(
    variant: Variant, turns: int
) -> None:
    emulator = Lms200Emulator(baud=38400, scan_source=ramp, variant=variant)
    emulator.state.configuration = INDICES
    payloads = asked(emulator, "20 24", until=3.0)
    indices = np.array([list(payload[-3:-1]) for payload in payloads])
    assert np.diff(indices[:, 1]).tolist() == [1] * (len(indices) - 1)
    wire_turns = 8 * turns  # a scan on its way takes so many
    assert set(np.diff(indices[:, 0]) % 256) == {wire_turns}
    assert indices[0, 0] % turns == 0


def test_what_does_not_fit_a_telegram_or_the_variant_is_refused() -> None:
    emulator = laser(Variant(100, 25))
    for at, command in enumerate(("75 01 00 01 00 91 01", "50 01 00 01 00", "37 01 00 92 01")):
        assert asked(emulator, command, 3.0 * at) == [b"\x92\x10"]


def test_addressed_laser_answers_to_its_number_and_to_all() -> None:
    emulator = laser(Variant(180, 100))
    emulator.state.address = 1
    for at, (address, heard) in enumerate(((0, True), (1, True), (2, False))):
        emulator.feed(encode_telegram(b"\x32", address), 1.0 * at)
        output = b"".join(item.data for item in emulator.pop_output(1.0 * at + 0.5))
        assert output[1:3] == (b"\x02\x81" if heard else b"")

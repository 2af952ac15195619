"""Monitored fields: kept, read back, and evaluated over the beams that end in them."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from drivers.lms200.emulator.emulator import Lms200Emulator
from drivers.lms200.emulator.fields import MonitoredFields, is_field
from drivers.lms200.framing import Telegram, TelegramFramer, encode_telegram
from drivers.lms200.measurement import UNIT_MM
from drivers.lms200.telegrams import Variant

INSTALL = b"\x20\x00SICK_LMS"
RECTANGLE = bytes.fromhex("01 E803 F401 D007")  # mm: 1 m right, 0.5 m left, 2 m ahead
RADIAL = b"\x02" + b"\xe8\x03" * 181  # 1 m all round
DEGREES = np.array([0.0, 60.0, 90.0, 120.0, 180.0])


def telegrams_to(emulator: Lms200Emulator, payload: bytes, t: float) -> list[bytes]:
    emulator.feed(encode_telegram(payload), t)
    output = b"".join(item.data for item in emulator.pop_output(t + 1.0))
    return [i.payload for i in TelegramFramer().feed(output) if isinstance(i, Telegram)]


class Scene:
    """All beams end at one distance, which may be changed."""

    distance = 5.0

    def __call__(self, t: float, n: int, increment: float) -> NDArray[np.float64]:
        return np.full(n, self.distance)


def test_rectangle_has_its_extent_to_each_side() -> None:
    fields = MonitoredFields()
    assert fields.write(1, RECTANGLE)
    for distance, inside in (
        (0.4, [1, 1, 1, 1, 1]),
        (0.9, [1, 1, 1, 1, 0]),
        (1.5, [0, 1, 1, 0, 0]),
    ):
        ranges = np.full(5, distance)
        found = fields.beams_inside(ranges, DEGREES, UNIT_MM)
        assert found[0].tolist() == [bool(beam) for beam in inside]
        assert not found[1].any()


def test_radial_field_holds_what_is_nearer_than_its_radii() -> None:
    fields = MonitoredFields()
    assert fields.write(2, RADIAL)
    found = fields.beams_inside(np.array([0.9, 1.1, np.inf, 0.5, 2.0]), DEGREES, UNIT_MM)
    assert found[1].tolist() == [True, False, False, True, False]


@pytest.mark.parametrize("content", [b"", b"\x00\x00", b"\x01\x00\x00", b"\x03", bytes(1001)])
def test_other_contents_are_refused(content: bytes) -> None:
    assert not is_field(content)
    assert not MonitoredFields().write(1, content)


def test_field_is_kept_over_a_power_cut_and_read_back() -> None:
    emulator = Lms200Emulator(baud=500000, scan_source=Scene())
    telegrams_to(emulator, INSTALL, 0.0)
    assert telegrams_to(emulator, b"\x40\x02" + RADIAL, 2.0) == [b"\xc0\x01\x10"]
    emulator.power_on(4.0)
    emulator.pop_output(6.0)
    assert telegrams_to(emulator, b"\x45\x02", 8.0) == [b"\xc5\x02" + RADIAL + b"\x10"]
    assert telegrams_to(emulator, b"\x45\x03", 10.0) == [b"\xc5\x03\x00\x10"]


def test_outputs_switch_with_the_scene_and_the_active_set() -> None:
    scene = Scene()
    emulator = Lms200Emulator(baud=9600, scan_source=scene, variant=Variant(180, 100))
    telegrams_to(emulator, INSTALL, 0.0)
    telegrams_to(emulator, b"\x40\x02" + RECTANGLE, 2.0)
    assert telegrams_to(emulator, b"\x4a", 4.0) == [b"\xca\x00\x00\x00\x10"]
    scene.distance = 0.7
    assert telegrams_to(emulator, b"\x4a", 6.0) == [b"\xca\x00\x01\x00\x10"]
    assert telegrams_to(emulator, b"\x41\x02", 8.0) == [b"\xc1\x01\x10"]
    assert telegrams_to(emulator, b"\x4a", 10.0) == [b"\xca\x00\x00\x00\x10"]


def test_taught_field_is_infringed_by_what_was_not_there() -> None:
    scene = Scene()
    emulator = Lms200Emulator(baud=500000, scan_source=scene, variant=Variant(180, 50))
    telegrams_to(emulator, INSTALL, 0.0)
    assert telegrams_to(emulator, b"\x46\x01", 2.0) == [b"\xc6\x01\x10"]
    assert telegrams_to(emulator, b"\x4a", 4.0) == [b"\xca\x00\x00\x00\x10"]
    scene.distance = 4.0
    assert telegrams_to(emulator, b"\x4a", 6.0) == [b"\xca\x01\x00\x00\x10"]


def test_output_on_infringement_begins_and_ends_with_it() -> None:
    scene = Scene()
    emulator = Lms200Emulator(baud=500000, scan_source=scene, variant=Variant(180, 100))
    telegrams_to(emulator, INSTALL, 0.0)
    telegrams_to(emulator, b"\x40\x01" + RADIAL, 2.0)
    assert len(telegrams_to(emulator, b"\x20\x21", 4.0)) == 1  # the reply alone
    scene.distance = 0.9
    assert len(emulator.pop_output(6.0)) > 50
    scene.distance = 5.0
    assert len(emulator.pop_output(7.0)) <= 1


def test_beams_in_fields_have_the_bits_of_the_measuring_mode() -> None:
    scene = Scene()
    scene.distance = 0.9
    for mode, bit in ((0x00, 0x40), (0x02, 0x40), (0x04, 0x80), (0x06, 0x00), (0x05, 0x00)):
        emulator = Lms200Emulator(baud=500000, scan_source=scene, variant=Variant(180, 100))
        telegrams_to(emulator, INSTALL, 0.0)
        telegrams_to(emulator, b"\x40\x02" + RADIAL, 2.0)  # field B
        telegrams_to(emulator, b"\x77" + bytes((0, 0, 0x46, 0, 0, mode, 1)), 4.0)
        (scan,) = telegrams_to(emulator, b"\x30\x01", 6.0)
        assert scan[3:5] == bytes((0x84, 0x03 | bit))

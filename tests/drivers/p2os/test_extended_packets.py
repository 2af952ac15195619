from __future__ import annotations

from collections.abc import Callable

import pytest

from drivers.p2os.extended_packets import (
    AuxPacket,
    BatteryPacket,
    EncoderPacket,
    GripperPacket,
    GyroPacket,
    GyroSample,
    IoPacket,
    JoystickPacket,
    Notification,
    decode_aux,
    decode_battery,
    decode_encoder,
    decode_gripper,
    decode_gyro,
    decode_io,
    decode_joystick,
    decode_notification,
)
from drivers.p2os.packets import Packet, decode_packet, is_known

# Packets of the protocol sheet's examples, and one of each kind without an example.
VECTORS: list[tuple[str, Packet]] = [
    ("90 E8 03 00 00 18 FC FF FF", EncoderPacket(1000, -1000)),
    ("98 01 08 02 1E", GyroPacket((GyroSample(520, 30),))),
    ("98 02 00 02 1E FF 01 1F", GyroPacket((GyroSample(512, 30), GyroSample(511, 31)))),
    ("98 00", GyroPacket(())),
    ("B0 90 50 00", AuxPacket(1, b"\x90\x50\x00")),
    ("B8 41", AuxPacket(2, b"A")),
    ("C8", AuxPacket(3, b"")),
    ("F0 02 FF 00 01 00 01 00 04", IoPacket(b"\xff\x00", b"\x00", (1024,))),
    ("F0 00 00 00", IoPacket(b"", b"", ())),
    ("F8 01 03 FF 03 00 02 01 00", JoystickPacket(1, 3, 1023, 512, 1)),
    ("E0 02 84 05", GripperPacket(2, 0x84, 5)),
    ("FA 02 05 01 02 03 64 63 00 00 00 50 4F", BatteryPacket(5, (b"\1\2\3dc", b"\0\0\0PO"))),
    ("FA 00 05", BatteryPacket(5, ())),
    ("FE", Notification(0xFE)),
    ("FF 07", Notification(0xFF, b"\x07")),
]
DECODERS: dict[int, Callable[[bytes], object]] = {
    0x90: decode_encoder,
    0x98: decode_gyro,
    0xB0: decode_aux,
    0xB8: decode_aux,
    0xC8: decode_aux,
    0xF0: decode_io,
    0xF8: decode_joystick,
    0xE0: decode_gripper,
    0xFA: decode_battery,
    0xFE: decode_notification,
    0xFF: decode_notification,
}


@pytest.mark.parametrize(("text", "packet"), VECTORS)
def test_vector_is_decoded_and_encoded(text: str, packet: Packet) -> None:
    data = bytes.fromhex(text)
    assert is_known(data)
    assert decode_packet(data) == DECODERS[data[0]](data) == packet
    assert packet.encode() == data


@pytest.mark.parametrize(
    ("text", "packet"),
    [pair for pair in VECTORS if not isinstance(pair[1], AuxPacket | Notification)],
)
def test_longer_packets_keep_surplus_and_shorter_ones_are_none(text: str, packet: Packet) -> None:
    data = bytes.fromhex(text)
    longer = decode_packet(data + b"\x01\x02")
    assert longer is not None
    assert longer.encode() == data + b"\x01\x02"
    for end in range(1, len(data)):
        assert decode_packet(data[:end]) is None

from __future__ import annotations

from drivers.p2os.extended_packets import (
    AuxPacket,
    EncoderPacket,
    GyroPacket,
    IoPacket,
    JoystickPacket,
)
from drivers.p2os.latest_packets import LatestPackets


def test_the_latest_of_each_kind_is_kept_with_its_time() -> None:
    latest = LatestPackets()
    assert latest.encoder is latest.gyro is latest.io is latest.joystick is None
    encoder, gyro = EncoderPacket(3, 4), GyroPacket(())
    io, joystick = IoPacket(b"\xff", b"", ()), JoystickPacket(1, 0, 512, 512, 0)
    for t, packet in enumerate((EncoderPacket(1, 2), encoder, gyro, io, joystick)):
        latest.update(packet, float(t))
    assert (latest.encoder, latest.gyro, latest.io, latest.joystick) == (
        encoder,
        gyro,
        io,
        joystick,
    )
    assert latest.received_at[EncoderPacket] == 1.0
    assert latest.received_at[JoystickPacket] == 4.0


def test_each_auxiliary_port_has_its_own() -> None:
    latest = LatestPackets()
    first, second = AuxPacket(1, b"a"), AuxPacket(3, b"b")
    latest.update(first, 0.0)
    latest.update(second, 1.0)
    assert latest.aux == {1: first, 3: second}

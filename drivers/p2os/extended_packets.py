"""The packets a robot sends beside its SIPs, on request or when it restarts; wire units.

Source: Pioneer 2 and H8-series Operations Manuals, extended packets. Each ``decode_...`` reads a
packet's data and returns None where it is cut short; ``encode`` gives the same bytes back.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import NamedTuple

ENCODER_TYPE = 0x90
GYRO_TYPE = 0x98
AUX_TYPES = (0xB0, 0xB8, 0xC8)
GRIPPER_TYPE = 0xE0
IO_TYPE = 0xF0
JOYSTICK_TYPE = 0xF8
BATTERY_TYPE = 0xFA
NOTIFICATION_TYPES = (0xFE, 0xFF)

_ENCODER = struct.Struct("<Bii")
_GYRO_SAMPLE = struct.Struct("<HB")
_JOYSTICK = struct.Struct("<BBBHHH")
_GRIPPER = struct.Struct("<BBBB")


@dataclass(frozen=True, slots=True)
class EncoderPacket:
    """Ticks of each wheel since the controller started, wrapping at 32 bits."""

    left_ticks: int
    right_ticks: int
    surplus: bytes = b""

    def encode(self) -> bytes:
        """Return the packet's data."""
        return _ENCODER.pack(ENCODER_TYPE, self.left_ticks, self.right_ticks) + self.surplus


class GyroSample(NamedTuple):
    """One gyro reading: about 512 of 0 to 1023 at rest, less when turning counter-clockwise."""

    rate_counts: int
    temperature_counts: int


@dataclass(frozen=True, slots=True)
class GyroPacket:
    """The gyro's readings since the last packet, oldest first."""

    samples: tuple[GyroSample, ...]
    surplus: bytes = b""

    def encode(self) -> bytes:
        """Return the packet's data."""
        samples = b"".join(_GYRO_SAMPLE.pack(*sample) for sample in self.samples)
        return bytes((GYRO_TYPE, len(self.samples))) + samples + self.surplus


@dataclass(frozen=True, slots=True)
class AuxPacket:
    """Bytes received at an auxiliary serial port, 1 to 3."""

    port: int
    data: bytes

    def encode(self) -> bytes:
        """Return the packet's data."""
        return bytes((AUX_TYPES[self.port - 1],)) + self.data


@dataclass(frozen=True, slots=True)
class IoPacket:
    """Digital inputs and outputs, and analog inputs as 0 to 5 V in 10 bits (P2OS: 11).

    The inputs are the user's, then front bumpers, rear bumpers and infrared. Here a bumper bit is
    0 when pressed.
    """

    inputs: bytes
    outputs: bytes
    analog_counts: tuple[int, ...]
    surplus: bytes = b""

    def encode(self) -> bytes:
        """Return the packet's data."""
        digital = b"".join(bytes((len(part),)) + part for part in (self.inputs, self.outputs))
        analog = struct.pack(
            f"<B{len(self.analog_counts)}H", len(self.analog_counts), *(self.analog_counts)
        )
        return bytes((IO_TYPE,)) + digital + analog + self.surplus


@dataclass(frozen=True, slots=True)
class JoystickPacket:
    """The robot's own joystick; positions are 0 to 1023."""

    connected: int
    buttons: int
    x_counts: int
    y_counts: int
    throttle_counts: int
    surplus: bytes = b""

    def encode(self) -> bytes:
        """Return the packet's data."""
        position = (self.x_counts, self.y_counts, self.throttle_counts)
        head = _JOYSTICK.pack(JOYSTICK_TYPE, self.connected, self.buttons, *position)
        return head + self.surplus


@dataclass(frozen=True, slots=True)
class GripperPacket:
    """The gripper: kind (0 none, 1 on the user's pins, 2 on its own), switches and grasp time."""

    kind: int
    switches: int
    grasp_time_20ms: int
    surplus: bytes = b""

    def encode(self) -> bytes:
        """Return the packet's data."""
        head = _GRIPPER.pack(GRIPPER_TYPE, self.kind, self.switches, self.grasp_time_20ms)
        return head + self.surplus


@dataclass(frozen=True, slots=True)
class BatteryPacket:
    """What batteries with a controller of their own report; lead-acid ones report nothing.

    ``records`` holds the bytes of each: three of flags, relative and absolute charge in percent
    (ARIA, ArRobotBatteryPacketReader), all of one size.
    """

    record_size: int
    records: tuple[bytes, ...]
    surplus: bytes = b""

    def encode(self) -> bytes:
        """Return the packet's data."""
        head = bytes((BATTERY_TYPE, len(self.records), self.record_size))
        return head + b"".join(self.records) + self.surplus


@dataclass(frozen=True, slots=True)
class Notification:
    """The controller has reset itself or lost the handshake: the session is over."""

    packet_type: int
    surplus: bytes = b""

    def encode(self) -> bytes:
        """Return the packet's data."""
        return bytes((self.packet_type,)) + self.surplus


def decode_encoder(data: bytes) -> EncoderPacket | None:
    """Read an ENCODER packet's data."""
    if len(data) < _ENCODER.size:
        return None
    _, left, right = _ENCODER.unpack_from(data)
    return EncoderPacket(left, right, data[_ENCODER.size :])


def decode_gyro(data: bytes) -> GyroPacket | None:
    """Read a GYRO packet's data."""
    end = 2 + _GYRO_SAMPLE.size * data[1] if len(data) > 1 else len(data) + 1
    if len(data) < end:
        return None
    samples = tuple(map(GyroSample._make, _GYRO_SAMPLE.iter_unpack(data[2:end])))
    return GyroPacket(samples, data[end:])


def decode_aux(data: bytes) -> AuxPacket | None:
    """Read a SERAUX, SERAUX2 or SERAUX3 packet's data."""
    return AuxPacket(AUX_TYPES.index(data[0]) + 1, data[1:])


def decode_io(data: bytes) -> IoPacket | None:
    """Read an IO packet's data."""
    parts: list[bytes] = []
    at = 1
    for item_size in (1, 1, 2):
        if at >= len(data) or len(data) < at + 1 + item_size * data[at]:
            return None
        end = at + 1 + item_size * data[at]
        parts.append(data[at + 1 : end])
        at = end
    analog = struct.unpack(f"<{len(parts[2]) // 2}H", parts[2])
    return IoPacket(parts[0], parts[1], analog, data[at:])


def decode_joystick(data: bytes) -> JoystickPacket | None:
    """Read a JOYSTICK packet's data."""
    if len(data) < _JOYSTICK.size:
        return None
    _, connected, buttons, x, y, throttle = _JOYSTICK.unpack_from(data)
    return JoystickPacket(connected, buttons, x, y, throttle, data[_JOYSTICK.size :])


def decode_gripper(data: bytes) -> GripperPacket | None:
    """Read a GRIPPER packet's data."""
    if len(data) < _GRIPPER.size:
        return None
    _, kind, switches, grasp_time = _GRIPPER.unpack_from(data)
    return GripperPacket(kind, switches, grasp_time, data[_GRIPPER.size :])


def decode_battery(data: bytes) -> BatteryPacket | None:
    """Read a BATTERYINFO packet's data."""
    if len(data) < 3 or len(data) < 3 + data[1] * data[2]:
        return None
    number, size = data[1], data[2]
    records = tuple(data[3 + size * i : 3 + size * (i + 1)] for i in range(number))
    return BatteryPacket(size, records, data[3 + size * number :])


def decode_notification(data: bytes) -> Notification | None:
    """Read a reset or sync notification's data."""
    return Notification(data[0], data[1:])

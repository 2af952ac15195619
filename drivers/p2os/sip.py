"""The standard information packet (SIP), the controller's report of every cycle, in wire units.

Source: Pioneer 2 Operations Manual, server information packet; the tail of later firmware after
the AROS and ARCOS manuals and their clients.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import Any, NamedTuple

COUNTS_PER_TURN = 4096
POSITION_MASK = 0x7FFF
"""The x and y counters have 15 significant bits."""
SIP_STOPPED = 0x32
SIP_MOVING = 0x33
SIP_TYPES = range(0x30, 0x40)
"""0x32 and 0x33 are documented; clients accept the others of the same row too."""
MOTORS_FLAG = 0x0001
SONAR_FLAGS = 0x001E
"""Bit 1 on P2OS; later firmware has a bit for each of four arrays."""
FIRST_ARRAY_FLAG = 0x0002
STOP_BUTTON_FLAG = 0x0020
"""This and those below are of later firmware; P2OS leaves them 0."""
E_STALL_FLAG = 0x0040
CHARGER_POWER_FLAG = 0x0400

_HEAD = struct.Struct("<BHHhhhBBBhHBB")
_SONAR = struct.Struct("<BH")
_TAIL_CODES = "BBBBBHBhHhbBII"
_TAILS = [struct.Struct("<" + _TAIL_CODES[:n]) for n in range(len(_TAIL_CODES) + 1)]
_TAIL_FOR_LENGTH = [
    max((tail for tail in _TAILS if tail.size <= length), key=lambda tail: tail.size)
    for length in range(_TAILS[-1].size + 1)
]


class SipTail(NamedTuple):
    """Fields behind the sonar readings; None if the packet ended before them.

    P2OS sends the first five, AROS seven, ARCOS nine and more; every field needs the ones before
    it. Manuals name gripper and analog port in the other order; ARIA and Player read the port
    first.
    """

    analog_port: int | None = None
    gripper_state: int | None = None
    analog: int | None = None  # 0 to 255 = 0 to 5 V
    digital_in: int | None = None
    digital_out: int | None = None
    battery_decivolts: int | None = None
    charge_state: int | None = None
    turn_rate_decidegrees_s: int | None = None
    fault_flags: int | None = None
    lateral_speed_mm_s: int | None = None
    temperature_celsius: int | None = None
    state_of_charge_percent: int | None = None
    controller_us: int | None = None
    flags3: int | None = None


@dataclass(frozen=True, slots=True)
class Sip:
    """One SIP as on the wire, counts and bit fields; ``base_state`` converts it to SI."""

    packet_type: int
    x_counts: int
    y_counts: int
    heading_counts: int  # COUNTS_PER_TURN = one turn, counter-clockwise positive
    left_speed_counts: int
    right_speed_counts: int
    battery_decivolts: int
    left_stall_byte: int  # bit 0 left wheel stalled, bits 1.. rear bumper segments
    right_stall_byte: int  # bit 0 right wheel stalled, bits 1.. front bumper segments
    control_counts: int  # heading setpoint
    flags: int
    compass_2deg: int
    sonar: tuple[tuple[int, int], ...]  # (transducer number from 0, range in counts), new ones only
    tail: SipTail
    surplus: bytes = b""  # bytes behind the last field known here

    @property
    def motors_enabled(self) -> bool:
        """Whether the motors have power."""
        return bool(self.flags & MOTORS_FLAG)

    @property
    def stop_button(self) -> bool:
        """Whether later firmware reports its stop button pressed."""
        return bool(self.flags & STOP_BUTTON_FLAG)

    @property
    def stalled_by_button(self) -> bool:
        """Whether later firmware reports a stall that its stop button is, not a blocked wheel."""
        return bool(self.flags & E_STALL_FLAG)

    @property
    def charger_power(self) -> bool:
        """Whether later firmware reports that the charger has power."""
        return bool(self.flags & CHARGER_POWER_FLAG)

    @property
    def is_of_later_firmware(self) -> bool:
        """Whether the packet has more fields than those of P2OS."""
        return self.tail.battery_decivolts is not None

    @property
    def sonar_on(self) -> bool:
        """Whether any sonar array fires."""
        return bool(self.flags & SONAR_FLAGS)

    def encode(self) -> bytes:
        """Return the packet's data; the exact inverse of ``decode_sip``."""
        head = _HEAD.pack(
            self.packet_type,
            self.x_counts,
            self.y_counts,
            self.heading_counts,
            self.left_speed_counts,
            self.right_speed_counts,
            self.battery_decivolts,
            self.left_stall_byte,
            self.right_stall_byte,
            self.control_counts,
            self.flags,
            self.compass_2deg,
            len(self.sonar),
        )
        readings = b"".join(_SONAR.pack(number, counts) for number, counts in self.sonar)
        present = [value for value in self.tail if value is not None]
        return head + readings + _TAILS[len(present)].pack(*present) + self.surplus


def is_sip(data: bytes) -> bool:
    """Whether a packet's data is a SIP, by its type."""
    return data[0] in SIP_TYPES


def decode_sip(data: bytes) -> Sip | None:
    """Decode a packet's data as a SIP; None if it is another packet or too short."""
    if len(data) < _HEAD.size or not is_sip(data):
        return None
    head = _HEAD.unpack_from(data)
    tail_at = _HEAD.size + _SONAR.size * head[-1]
    if len(data) < tail_at:
        return None
    sonar = tuple(_SONAR.iter_unpack(data[_HEAD.size : tail_at]))
    tail = _TAIL_FOR_LENGTH[min(len(data) - tail_at, len(_TAIL_FOR_LENGTH) - 1)]
    values = tail.unpack_from(data, tail_at)
    surplus = data[tail_at + tail.size :]
    fields: tuple[Any, ...] = (*head[:-1], sonar, SipTail(*values), surplus)
    return Sip(*fields)

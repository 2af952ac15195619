"""Telegram frames of the SICK LMS 2xx: STX, address, length, command and data, CRC-16.

Source: SICK "Telegrams for Configuring and Operating the LMS2xx", 8007954/Q501, framing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

STX = 0x02
ACK = 0x06
NAK = 0x15
REPLY_BIT = 0x80  # set in the address, and in the first data byte, of what the laser sends

HOST_ADDRESSES = range(0x80)  # of telegrams to a laser; 0 is any laser
LASER_ADDRESSES = range(0x80, 0x100)  # of telegrams from a laser

OVERHEAD = 6  # STX, address, two length bytes, two CRC bytes
MAX_PAYLOAD = 808  # 401 values with both indices, status: 814 bytes on the wire

_POLYNOMIAL = 0x8005
_ACK_AND_STX = bytes((ACK, STX))


def _crc_contributions() -> NDArray[np.uint16]:
    """Return what byte b adds to the CRC, by distance from the end: shape (frame, 256).

    The CRC shifts by one bit per byte and is linear, so it is the XOR of what each byte
    contributes. A byte enters twice: as itself, and, with the next byte, shifted up by 8.
    The last row is the last byte.
    """
    rows = MAX_PAYLOAD + OVERHEAD - 2
    table = np.empty((rows, 256), dtype=np.uint16)
    byte = np.arange(256, dtype=np.uint16)
    table[-1] = byte
    table[-2] = byte << 1 ^ byte << 8
    for row in range(rows - 3, -1, -1):
        later = table[row + 1]
        table[row] = later << 1 ^ (later >> 15) * np.uint16(_POLYNOMIAL)
    return table


_CONTRIBUTIONS = _crc_contributions().ravel()
_ROW_STARTS = np.arange(0, _CONTRIBUTIONS.size, 256)


def crc16(data: bytes | bytearray) -> int:
    """Return the CRC-16 of a frame's bytes from STX up to the CRC; at most 812 bytes."""
    octets = np.frombuffer(data, dtype=np.uint8)
    contributions = _CONTRIBUTIONS[_ROW_STARTS[_ROW_STARTS.size - octets.size :] + octets]
    return int(np.bitwise_xor.reduce(contributions))


def encode_telegram(command: bytes, address: int = 0) -> bytes:
    """Frame command and data bytes (1 to 808) for an address; 0 is any laser.

    Raises ValueError where the length cannot be framed.
    """
    if not 1 <= len(command) <= MAX_PAYLOAD:
        raise ValueError(f"a telegram carries 1 to {MAX_PAYLOAD} bytes, not {len(command)}")
    frame = bytes((STX, address)) + len(command).to_bytes(2, "little") + command
    return frame + crc16(frame).to_bytes(2, "little")


@dataclass(frozen=True, slots=True)
class Telegram:
    """One frame whose CRC is right.

    ``payload`` is command and data (with the status byte last, from a laser). ``bytes_after``
    counts the bytes already received behind the frame: they arrived after it.
    """

    address: int
    payload: bytes
    bytes_after: int = 0

    @property
    def code(self) -> int:
        """Command or reply code, the first byte of the payload."""
        return self.payload[0]

    @property
    def wire_length(self) -> int:
        """Bytes the whole frame takes on the wire."""
        return len(self.payload) + OVERHEAD


@dataclass(frozen=True, slots=True)
class Ack:
    """The raw byte 06: a command was understood, its reply follows."""


@dataclass(frozen=True, slots=True)
class Nak:
    """The raw byte 15: a command was not understood."""


@dataclass(slots=True)
class FramerCounters:
    """Counts of the bytes and frames received."""

    good: int = 0
    bad_checksum: int = 0
    discarded_bytes: int = 0


class TelegramFramer:
    """Finds telegrams, ACKs and NAKs in a byte stream; accepts any bytes and never raises.

    Takes telegrams whose address is in ``addresses``. After a bad CRC the search resumes at the
    byte after the failed STX. Holds at most one frame's length of bytes between calls.
    """

    def __init__(self, addresses: range = LASER_ADDRESSES) -> None:
        self.counters = FramerCounters()
        self.examined_bytes = 0
        """Bytes tested as a frame's start or summed for its CRC; a byte counts once for every frame
        it might belong to."""
        self._addresses = addresses
        self._buffer = bytearray()

    @property
    def pending(self) -> bool:
        """Whether an unfinished frame is buffered."""
        return bool(self._buffer)

    def feed(self, data: bytes) -> list[Telegram | Ack | Nak]:
        """Take bytes; return what they complete, in order of arrival."""
        self._buffer += data
        return self._search()

    def flush(self) -> list[Telegram | Ack | Nak]:
        """Discard the unfinished frame after a silence; return what was complete behind its STX."""
        found: list[Telegram | Ack | Nak] = []
        while self._buffer:
            del self._buffer[0]
            self.counters.discarded_bytes += 1
            found += self._search()
        return found

    def reset(self) -> None:
        """Discard the bytes of an unfinished frame."""
        self.counters.discarded_bytes += len(self._buffer)
        self._buffer.clear()

    def break_off(self, *, silent: bool = False) -> list[Telegram | Ack | Nak]:
        """Return what stands in an unfinished frame that the laser broke off to answer a command.

        That is an ACK and a whole telegram behind it; after a silence an ACK at the end also does.
        Nothing is changed where there is none. The frame's own bytes are not counted as discarded.
        """
        buffer = self._buffer
        at = buffer.find(_ACK_AND_STX, 1)
        while at >= 0:
            if self._frame_length(at + 1):
                del buffer[:at]
                return self._search()
            at = buffer.find(_ACK_AND_STX, at + 1)
        if silent and len(buffer) > 1 and buffer[-1] == ACK:
            buffer.clear()
            return [Ack()]
        return []

    def _search(self) -> list[Telegram | Ack | Nak]:
        buffer = self._buffer
        found: list[Telegram | Ack | Nak] = []
        at = 0
        while at < len(buffer):
            first = buffer[at]
            self.examined_bytes += 1
            if first == STX:
                length = self._frame_length(at)
                if length is None:
                    break
                if length:
                    found.append(self._pop(at, length))
                    at += length
                    continue
            elif first == ACK:
                found.append(Ack())
                at += 1
                continue
            elif first == NAK:
                found.append(Nak())
                at += 1
                continue
            self.counters.discarded_bytes += 1
            at += 1
        del buffer[:at]
        return found

    def _frame_length(self, at: int) -> int | None:
        """Return the length of the valid frame at ``at``; 0: there is none, None: incomplete."""
        buffer = self._buffer
        received = len(buffer) - at
        if received > 1 and buffer[at + 1] not in self._addresses:
            return 0
        if received < 4:
            return None
        payload_length = buffer[at + 2] | buffer[at + 3] << 8
        if not 1 <= payload_length <= MAX_PAYLOAD:
            return 0
        length = payload_length + OVERHEAD
        if received < length:
            return None
        end = at + length
        self.examined_bytes += length
        if crc16(buffer[at : end - 2]) != buffer[end - 2] | buffer[end - 1] << 8:
            self.counters.bad_checksum += 1
            return 0
        return length

    def _pop(self, at: int, length: int) -> Telegram:
        self.counters.good += 1
        payload = bytes(self._buffer[at + 4 : at + length - 2])
        return Telegram(self._buffer[at + 1], payload, len(self._buffer) - at - length)

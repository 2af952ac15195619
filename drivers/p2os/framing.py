"""P2OS packets on the wire: ``FA FB count data checksum``, both directions.

Source: Pioneer 2 Operations Manual, packet protocol. ``count`` is the number of data bytes plus
the two checksum bytes; the checksum is big-endian, everything else in a packet little-endian.
"""

from __future__ import annotations

from dataclasses import dataclass

HEADER = b"\xfa\xfb"
MIN_COUNT = 3
MAX_COUNT = 255
CONTROLLER_MAX_COUNT = 200
"""The largest count a P2OS controller accepts from its client."""
OVERHEAD = 5
"""Bytes on the wire that are not data: header, count and checksum."""


def checksum(data: bytes | bytearray) -> int:
    """Return the 16-bit checksum of a packet's data: byte pairs added, an odd last byte XORed."""
    even = len(data) & ~1
    total = (sum(data[0:even:2]) * 256 + sum(data[1:even:2])) & 0xFFFF
    return total ^ data[-1] if len(data) & 1 else total


def encode_packet(data: bytes) -> bytes:
    """Frame 1 to 253 data bytes as one packet; raises ValueError when there are more or none."""
    count = len(data) + 2
    if not MIN_COUNT <= count <= MAX_COUNT:
        raise ValueError(f"a P2OS packet holds 1 to {MAX_COUNT - 2} data bytes, not {len(data)}")
    return b"".join((HEADER, bytes((count,)), data, checksum(data).to_bytes(2, "big")))


@dataclass(slots=True)
class FramingCounters:
    """Counts of packets and bytes received."""

    good: int = 0
    bad_checksum: int = 0
    discarded_bytes: int = 0


class PacketFramer:
    """Finds packets in a byte stream; noise is skipped and counted, never raised.

    Data is not escaped, so a header may be a coincidence: after a bad checksum or an impossible
    count the search resumes at the byte behind the failed ``FA``. At most one unfinished packet
    (258 bytes) is buffered between calls.
    """

    def __init__(self, max_count: int = MAX_COUNT) -> None:
        self.counters = FramingCounters()
        self.examined_bytes = 0
        """Bytes searched for a header or summed for a checksum; a byte counts once for every
        packet it might belong to."""
        self._max_count = max_count
        self._buffer = bytearray()

    @property
    def pending(self) -> int:
        """Number of bytes waiting for the rest of their packet."""
        return len(self._buffer)

    def reset(self) -> None:
        """Discard the unfinished packet."""
        self.counters.discarded_bytes += len(self._buffer)
        self._buffer.clear()

    def feed(self, data: bytes) -> list[bytes]:
        """Take bytes from the line; return the data of every packet they complete."""
        self._buffer += data
        return self._pop_packets()

    def abandon_packet(self) -> list[bytes]:
        """Discard the unfinished packet; return packets that were complete behind its header."""
        if not self._buffer:
            return []
        self.counters.discarded_bytes += 1
        del self._buffer[0]
        return self._pop_packets()

    def _pop_packets(self) -> list[bytes]:
        buffer = self._buffer
        counters = self.counters
        packets: list[bytes] = []
        at = 0
        while (header := buffer.find(HEADER, at)) >= 0:
            counters.discarded_bytes += header - at
            self.examined_bytes += header - at + len(HEADER)
            at = header
            if len(buffer) < at + 3:
                break
            end = at + 3 + buffer[at + 2]
            possible = MIN_COUNT <= buffer[at + 2] <= self._max_count
            if possible and len(buffer) < end:
                break
            if possible and (data := self._checked_data(at, end)) is not None:
                counters.good += 1
                packets.append(data)
                at = end
            else:
                counters.bad_checksum += possible
                counters.discarded_bytes += 1
                at += 1
        else:
            half_header = buffer.endswith(HEADER[:1], at)
            self.examined_bytes += len(buffer) - at
            counters.discarded_bytes += len(buffer) - at - half_header
            at = len(buffer) - half_header
        del buffer[:at]
        return packets

    def _checked_data(self, start: int, end: int) -> bytes | None:
        """Return the data of the packet between two places in the buffer; None if damaged."""
        self.examined_bytes += end - start
        data = bytes(self._buffer[start + 3 : end - 2])
        stated = self._buffer[end - 2] << 8 | self._buffer[end - 1]
        return data if checksum(data) == stated else None

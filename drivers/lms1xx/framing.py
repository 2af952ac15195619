"""Telegram frames of SOPAS scanners: CoLa A (text between STX and ETX) and CoLa B (binary).

Source: SICK "Telegram Listing" 8014631 for LMS1xx, LMS5xx and TiM, communication format.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

STX = 0x02
ETX = 0x03
MAX_PAYLOAD = 0xFFFF
"""Ours: distances and remissions of two echoes of 1141 beams take 20 kB in CoLa A."""

ETHERNET = 100_000_000
"""bit/s of the scanner's network: what stands for the rate of a serial line."""

_PREFIX = bytes((STX,)) * 4  # of CoLa B
_HEAD = len(_PREFIX) + 4  # with the length, big-endian
_FIRST = ord("s")  # every command begins with it
_KIND = re.compile(rb"s[A-Z]{2}")  # of a command; an XOR alone is right once in 256 times
_CONTROL = re.compile(rb"[\x00-\x1f]")  # none of them is in the text of CoLa A


class Dialect(StrEnum):
    """The two ways to write the same telegrams."""

    A = "CoLa A"
    B = "CoLa B"


def checksum(payload: bytes | bytearray) -> int:
    """Return the XOR of all bytes."""
    return int(np.bitwise_xor.reduce(np.frombuffer(payload, dtype=np.uint8)))


@dataclass(frozen=True, slots=True)
class Telegram:
    """One frame, complete and, in CoLa B, with the right checksum.

    ``bytes_after`` counts the bytes already received behind the frame.
    """

    dialect: Dialect
    payload: bytes
    bytes_after: int = 0

    @property
    def command(self) -> str:
        """Kind and name, e.g. ``sRA LMDscandata``."""
        return b" ".join(self.payload.split(b" ", 2)[:2]).decode("ascii", errors="replace")

    @property
    def data(self) -> bytes:
        """What follows kind and name and the space after them."""
        parts = self.payload.split(b" ", 2)
        return parts[2] if len(parts) > 2 else b""


def encode_telegram(payload: bytes, dialect: Dialect) -> bytes:
    """Frame a payload, 1 to 65535 bytes; ValueError where its length cannot be framed."""
    if not 1 <= len(payload) <= MAX_PAYLOAD:
        raise ValueError(f"a telegram carries 1 to {MAX_PAYLOAD} bytes, not {len(payload)}")
    if dialect is Dialect.A:
        return bytes((STX, *payload, ETX))
    return _PREFIX + len(payload).to_bytes(4, "big") + payload + bytes((checksum(payload),))


@dataclass(slots=True)
class FramerCounters:
    """Counts of the bytes and frames received."""

    good: int = 0
    bad_checksum: int = 0
    discarded_bytes: int = 0


class TelegramFramer:
    """Finds the telegrams of both dialects in a byte stream; accepts any bytes and never raises.

    After a bad frame the search resumes at the byte after its STX. Holds at most one frame's
    length of bytes between calls.
    """

    def __init__(self) -> None:
        self.counters = FramerCounters()
        self._buffer = bytearray()
        self._text_until = 0  # the unfinished text of CoLa A has been looked through up to here

    @property
    def pending(self) -> bool:
        """Whether an unfinished frame is buffered."""
        return bool(self._buffer)

    def feed(self, data: bytes) -> list[Telegram]:
        """Take bytes; return the telegrams they complete, in order of arrival."""
        self._buffer += data
        return self._search()

    def flush(self) -> list[Telegram]:
        """Discard the unfinished frame after a silence; return what was complete behind its STX."""
        found: list[Telegram] = []
        while self._buffer:
            del self._buffer[0]
            self._text_until = 0
            self.counters.discarded_bytes += 1
            found += self._search()
        return found

    def reset(self) -> None:
        """Discard the bytes of an unfinished frame."""
        self.counters.discarded_bytes += len(self._buffer)
        self._buffer.clear()
        self._text_until = 0

    def _search(self) -> list[Telegram]:
        buffer = self._buffer
        found: list[Telegram] = []
        at = 0
        while (start := buffer.find(STX, at)) >= 0:
            self.counters.discarded_bytes += start - at
            at = start
            frame = self._frame_at(at)
            if frame is None:
                break
            dialect, begin, end, length = frame
            if not length:
                self.counters.discarded_bytes += 1
                at += 1
                continue
            self.counters.good += 1
            payload = bytes(buffer[begin:end])
            found.append(Telegram(dialect, payload, len(buffer) - at - length))
            at += length
        else:
            self.counters.discarded_bytes += len(buffer) - at
            at = len(buffer)
        self._text_until = max(self._text_until - at, 0)
        del buffer[:at]
        return found

    def _frame_at(self, at: int) -> tuple[Dialect, int, int, int] | None:
        """Return dialect, payload's begin and end, and length of the frame at ``at``.

        Length 0: there is none; None: it is incomplete.
        """
        buffer = self._buffer
        if len(buffer) - at < 2:
            return None
        if buffer[at + 1] == _FIRST:
            return self._text_at(at)
        none = Dialect.B, at, at, 0
        if not _PREFIX.startswith(buffer[at : at + 4]):
            return none
        if len(buffer) - at < _HEAD + 3:
            return None
        size = int.from_bytes(buffer[at + 4 : at + _HEAD], "big")
        if not 3 <= size <= MAX_PAYLOAD or not _KIND.match(buffer, at + _HEAD):
            return none
        begin, end = at + _HEAD, at + _HEAD + size
        if len(buffer) <= end:
            return None
        if checksum(buffer[begin:end]) != buffer[end]:
            self.counters.bad_checksum += 1
            return none
        return Dialect.B, begin, end, _HEAD + size + 1

    def _text_at(self, at: int) -> tuple[Dialect, int, int, int] | None:
        buffer = self._buffer
        control = _CONTROL.search(buffer, max(at + 1, self._text_until))
        end = len(buffer) if control is None else control.start()
        none = Dialect.A, at, at, 0
        if end - at - 1 > MAX_PAYLOAD:
            return none
        if control is None:
            self._text_until = end
            return None
        if buffer[end] != ETX:
            return none
        return Dialect.A, at + 1, end, end + 1 - at

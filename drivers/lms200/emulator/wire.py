"""The laser's sending side of the line: one byte after another, at the rate in force."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

from drivers.emulation.timed_bytes import TimedBytes

_BITS_PER_BYTE = 10
_ROUNDING = 1e-6  # of a byte


@dataclass(frozen=True, slots=True)
class _Outgoing:
    """Bytes that are sent from ``begin`` to ``end`` (s).

    measured: of measured values. ``baud_after`` is the rate from then on, None for no change.
    """

    begin: float
    end: float
    data: bytes
    measured: bool
    baud_after: int | None = None


class LaserWire:
    """Paces what a laser sends.

    ``baud`` is the rate of the bytes taken so far, ``free`` when the wire will be free (s). Without
    ``paced`` bytes take no time until a rate is ordered: a line without a rate, as TCP is.
    """

    def __init__(self, baud: int, *, paced: bool = True) -> None:
        self.baud = baud
        self.free = 0.0
        self._paced = paced
        self._byte_time = _BITS_PER_BYTE / baud if paced else 0.0
        self._sent: deque[_Outgoing] = deque()

    def send(
        self, data: bytes, t: float, *, measured: bool = False, baud_after: int | None = None
    ) -> None:
        """Send bytes at ``t`` or once the wire is free; measured: of measured values."""
        begin = max(t, self.free)
        self.free = begin + len(data) * self._byte_time
        self._sent.append(_Outgoing(begin, self.free, data, measured, baud_after))
        if baud_after is not None:
            self._byte_time = _BITS_PER_BYTE / baud_after

    def break_off(self, t: float) -> None:
        """Break off the measured values that are being sent; the byte under way is completed."""
        if not self._sent or not self._sent[-1].measured or self._sent[-1].end <= t:
            return
        cut = self._sent.pop()
        if cut.begin >= t:  # its sweep has not ended yet
            self.free = self._sent[-1].end if self._sent else t
            return
        sent_bytes = math.ceil((t - cut.begin) / self._byte_time - _ROUNDING)
        self.free = cut.begin + sent_bytes * self._byte_time
        kept = cut.data[:sent_bytes]
        self._sent.append(_Outgoing(cut.begin, self.free, kept, measured=False))

    def pop(self, t: float) -> list[TimedBytes]:
        """Return what has wholly left by ``t``, in order; one call returns bytes of one rate."""
        output: list[TimedBytes] = []
        while self._sent and self._sent[0].end <= t:
            outgoing = self._sent.popleft()
            output.append(TimedBytes(outgoing.end, outgoing.data))
            if outgoing.baud_after is not None:
                self.baud = outgoing.baud_after
                break
        return output

    def clear(self) -> None:
        """Drop what has not been taken: the power is cut."""
        self._sent.clear()

    def restart(self, baud: int) -> None:
        """Send at the rate at which the laser is switched on."""
        self.baud = baud
        self.drop_order(baud)

    def drop_order(self, baud: int) -> None:
        """Send from now on at a rate that nobody ordered."""
        self._byte_time = _BITS_PER_BYTE / baud if self._paced else 0.0

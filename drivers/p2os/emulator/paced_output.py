"""The sending side of an emulated serial line: bytes leave in order at the line's rate."""

from __future__ import annotations

import math
from collections import deque

from drivers.emulation.timed_bytes import TimedBytes

BITS_PER_BYTE = 10  # start bit, eight data bits, stop bit


class PacedOutput:
    """Queues packets and returns each once its last byte has left the wire."""

    def __init__(self) -> None:
        self._queue: deque[TimedBytes] = deque()
        self._free_at = -math.inf

    def send(self, data: bytes, t: float, baud: int) -> None:
        """Queue ``data``; it starts at ``t``, or as soon as everything before it has left."""
        self._free_at = max(t, self._free_at) + len(data) * BITS_PER_BYTE / baud
        self._queue.append(TimedBytes(self._free_at, data))

    def has_room(self, size: int, t: float, baud: int, limit: float) -> bool:
        """Whether ``size`` bytes queued at ``t`` would have left by ``limit``."""
        return max(t, self._free_at) + size * BITS_PER_BYTE / baud <= limit

    def pop(self, t: float) -> list[TimedBytes]:
        """Return and remove what has left the wire by ``t``, in order."""
        left = []
        while self._queue and self._queue[0].t <= t:
            left.append(self._queue.popleft())
        return left

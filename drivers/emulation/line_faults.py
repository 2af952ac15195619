"""Fault injection on a device's line: faults of cable and adapter, and device resets.

Wraps an emulated device and is one itself. All random draws come from a given generator: the same
seed and the same traffic give the same faults.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from drivers.emulation.fault_plan import FaultPlan
from drivers.emulation.port import EmulatedDevice
from drivers.emulation.timed_bytes import TimedBytes

SPLIT_GAP = 0.02  # s between the halves of bytes that are split
_BITS_PER_BYTE = 10


@dataclass(slots=True)
class FaultCounters:
    """Faults injected so far, both ways."""

    passed_bytes: int = 0
    dropped_bytes: int = 0
    corrupted_bytes: int = 0
    silenced_bytes: int = 0
    duplicates: int = 0
    splits: int = 0
    delays: int = 0
    cuts: int = 0
    resets: int = 0


@dataclass(slots=True)
class _Direction:
    """Bytes in transit in one direction, first in, first out."""

    rng: np.random.Generator
    under_way: deque[TimedBytes] = field(default_factory=deque)
    latest: float = -math.inf

    def put(self, data: bytes, t: float) -> None:
        self.latest = max(self.latest, t)
        self.under_way.append(TimedBytes(self.latest, data))

    def arrived(self, t: float) -> list[TimedBytes]:
        found = []
        while self.under_way and self.under_way[0].t <= t:
            found.append(self.under_way.popleft())
        return found


class LineFaults:
    """An emulated device behind a line with faults, by a plan and by switches set at run time.

    The owner may set ``on_cut(t)`` and ``on_restored(t)`` (take the port away, bring it back) and
    ``on_reset(t)`` (restart the device); they are called when due, during ``feed`` or
    ``pop_output``.
    """

    def __init__(self, device: EmulatedDevice, plan: FaultPlan, rng: np.random.Generator) -> None:
        self.plan = plan
        self.deaf = False
        """Drop all bytes from the client."""
        self.mute = False
        """Drop all bytes from the device."""
        self.frozen = False
        """Repeat the device's last packet or telegram in place of each new one."""
        self.spoilt = 0.0
        """Share of the device's packets that arrive with one byte wrong."""
        self.late = 0.0
        """Delay of all bytes from the device, s."""
        self._last = b""
        self.counters = FaultCounters()
        self.on_cut: Callable[[float], None] = _nothing
        self.on_restored: Callable[[float], None] = _nothing
        self.on_reset: Callable[[float], None] = _nothing
        self._device = device
        self._to_device, self._from_device = (_Direction(child) for child in rng.spawn(2))
        self._start: float | None = None
        self._cut = False
        self._resets_done = 0

    @property
    def baud(self) -> int:
        """The device's present rate."""
        return self._device.baud

    def feed(self, data: bytes, t: float) -> None:
        """Pass bytes from the client to the device, with the line's faults."""
        self._apply_plan(t)
        if not self.deaf:
            self._send(self._to_device, data, t)
        self._deliver(t)

    def pop_output(self, t: float) -> list[TimedBytes]:
        """Return the device's bytes that have arrived by ``t``, with the line's faults."""
        self._apply_plan(t)
        self._deliver(t)
        for item in self._device.pop_output(t):
            if not self.frozen:
                self._last = item.data
            if not self.mute:
                self._send(self._from_device, self._corrupt_packet(self._last), item.t + self.late)
        return self._from_device.arrived(t)

    def _apply_plan(self, t: float) -> None:
        """Call what is due at ``t``: cut, restore, reset."""
        if self._start is None:
            self._start = t
        elapsed = t - self._start
        cut = any(elapsed in span for span in self.plan.cuts)
        if cut != self._cut:
            self._cut = cut
            self.counters.cuts += cut
            (self.on_cut if cut else self.on_restored)(t)
        while self._resets_done < len(self.plan.resets):
            if elapsed < self.plan.resets[self._resets_done]:
                break
            self._resets_done += 1
            self.counters.resets += 1
            self.on_reset(t)

    def _deliver(self, t: float) -> None:
        for item in self._to_device.arrived(t):
            self._device.feed(item.data, t)

    def _send(self, direction: _Direction, data: bytes, t: float) -> None:
        """Put bytes sent at ``t`` in transit, with faults injected."""
        if self._is_silent(t):
            self.counters.silenced_bytes += len(data)
            return
        plan, counters = self.plan, self.counters
        duplicate, split, delay, place = direction.rng.random(4)
        data = self._corrupt_bytes(data, direction.rng)
        if delay < plan.delay:
            counters.delays += 1
            t += plan.delay_time
        if duplicate < plan.duplicate:
            counters.duplicates += 1
            data += data
        counters.passed_bytes += len(data)
        if split < plan.split and len(data) > 1:
            counters.splits += 1
            at = 1 + int(place * (len(data) - 1))
            behind = (len(data) - at) * _BITS_PER_BYTE / self.baud
            direction.put(data[:at], t - behind)
            data, t = data[at:], t + SPLIT_GAP
        if data:
            direction.put(data, t)

    def _corrupt_packet(self, packet: bytes) -> bytes:
        """Return a packet, at rate ``spoilt`` with one byte wrong."""
        rng = self._from_device.rng
        if not self.spoilt or rng.random() >= self.spoilt:
            return packet
        place = int(rng.integers(len(packet)))
        wrong = packet[place] ^ int(rng.integers(1, 256))
        return packet[:place] + bytes((wrong,)) + packet[place + 1 :]

    def _corrupt_bytes(self, data: bytes, rng: np.random.Generator) -> bytes:
        """Return data with single bytes dropped and single bits flipped."""
        if not self.plan.drop and not self.plan.corrupt:
            return data
        octets = np.frombuffer(data, dtype=np.uint8)
        chances = rng.random((2, octets.size))
        hit = chances[0] < self.plan.corrupt
        kept = chances[1] >= self.plan.drop
        bits = np.left_shift(1, rng.integers(8, size=octets.size)).astype(np.uint8)
        self.counters.corrupted_bytes += int(np.count_nonzero(hit & kept))
        self.counters.dropped_bytes += int(np.count_nonzero(~kept))
        return bytes(np.where(hit, octets ^ bits, octets)[kept])

    def _is_silent(self, t: float) -> bool:
        elapsed = t - (self._start or 0.0)
        return any(elapsed in span for span in (*self.plan.silences, *self.plan.cuts))


def _nothing(_t: float) -> None:
    return None

"""The firing order of emulated sonar rings: one transducer of each ring every 40 ms."""

from __future__ import annotations

from collections.abc import Sequence

FIRING_PERIOD = 0.040  # s
RING_SIZE = 8


class SonarFiring:
    """Schedules the transducers; front and rear ring fire together."""

    def __init__(self, transducers: int) -> None:
        self._transducers = transducers
        self._rings: list[list[int]] = []
        self.set_order(range(transducers))
        self._firing_since: float | None = None
        self._shots = 0

    @property
    def is_on(self) -> bool:
        """Whether the transducers fire."""
        return self._firing_since is not None

    def set_order(self, numbers: Sequence[int]) -> None:
        """Fire only these transducers (from 0), each ring in the order given."""
        fitted = [number for number in numbers if 0 <= number < self._transducers]
        starts = range(0, self._transducers, RING_SIZE)
        rings = ([n for n in fitted if start <= n < start + RING_SIZE] for start in starts)
        self._rings = [ring for ring in rings if ring]

    def start(self, t: float) -> None:
        """Begin firing at ``t``; no effect when already firing."""
        if self._firing_since is None:
            self._firing_since = t
            self._shots = 0

    def stop(self) -> None:
        """Stop firing."""
        self._firing_since = None

    def pop_fired(self, t: float) -> list[int]:
        """Return the transducers that fired since the last call, in order, each at most once."""
        if self._firing_since is None:
            return []
        shots = int((t - self._firing_since) / FIRING_PERIOD + 1e-6)
        since = range(max(self._shots, shots - RING_SIZE), shots)
        self._shots = shots
        fired = (ring[shot % len(ring)] for shot in since for ring in self._rings)
        return list(dict.fromkeys(fired))

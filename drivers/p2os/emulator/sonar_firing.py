"""The firing order of emulated sonar arrays: one transducer of each array every 40 ms."""

from __future__ import annotations

from collections.abc import Sequence

FIRING_PERIOD = 0.040  # s
ARRAY_SIZE = 8


class SonarFiring:
    """Schedules the transducers; those arrays that are on, as front and rear, fire together."""

    def __init__(self, transducers: int) -> None:
        self._transducers = transducers
        self._arrays: list[list[int]] = []
        self.set_order(range(transducers))
        self._on: set[int] = set()
        self._period = FIRING_PERIOD
        self._firing_since = 0.0
        self._shots = 0

    @property
    def is_on(self) -> bool:
        """Whether any transducers fire."""
        return bool(self._on)

    @property
    def on(self) -> frozenset[int]:
        """The arrays that fire, from 0."""
        return frozenset(self._on)

    def set_order(self, numbers: Sequence[int]) -> None:
        """Fire only these transducers (from 0), each array in the order given."""
        starts = range(0, self._transducers, ARRAY_SIZE)
        self._arrays = [
            [n for n in numbers if start <= n < min(start + ARRAY_SIZE, self._transducers)]
            for start in starts
        ]

    def set_period(self, period: float, t: float) -> None:
        """Fire every ``period`` s from ``t`` on."""
        self._period = period
        self._firing_since = t
        self._shots = 0

    def start(self, t: float, array: int | None = None) -> None:
        """Begin firing at ``t``, with one array or all; no effect on those already firing."""
        if not self._on:
            self._firing_since = t
            self._shots = 0
        self._on |= self._chosen(array)

    def stop(self, array: int | None = None) -> None:
        """Stop firing, with one array or all."""
        self._on -= self._chosen(array)

    def pop_fired(self, t: float) -> list[int]:
        """Return the transducers that fired since the last call, in order, each at most once."""
        order = [ring for i, ring in enumerate(self._arrays) if ring and i in self._on]
        if not self._on:
            return []
        shots = int((t - self._firing_since) / self._period + 1e-6)
        longest = max(map(len, order), default=0)
        since = range(max(self._shots, shots - longest), shots)
        self._shots = shots
        fired = (ring[shot % len(ring)] for shot in since for ring in order)
        return list(dict.fromkeys(fired))

    def _chosen(self, array: int | None) -> set[int]:
        every = range(len(self._arrays))
        return set(every) if array is None else {array} & set(every)

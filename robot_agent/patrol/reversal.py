"""The random reversal of Keep Going, which makes a patrol less predictable."""

from __future__ import annotations

import numpy as np


class RandomReversal:
    """Every period s, with some probability, asks a robot that keeps going to turn back.

    The first time comes after a random part of the period, so that a team is not in step.
    """

    def __init__(self, period: float, probability: float, rng: np.random.Generator) -> None:
        self._period = period
        self._probability = probability
        self._rng = rng
        self._next: float | None = None

    def due(self, t: float, *, permitted: bool) -> bool:
        """Tell whether to turn back at t, s. A time that passes while not permitted is lost."""
        if self._next is None:
            self._next = t + float(self._rng.uniform(0.0, self._period))
        if t < self._next:
            return False
        while self._next <= t:
            self._next += self._period
        return permitted and float(self._rng.random()) < self._probability

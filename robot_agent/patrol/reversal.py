"""The random reversal of Keep Going, which makes a patrol less predictable."""

from __future__ import annotations

from typing import Literal

import numpy as np

Distribution = Literal["fixed", "uniform", "exponential"]


class RandomReversal:
    """Now and then, with some probability, asks a robot that keeps going to turn back.

    The times between lie a period, s, apart (fixed, as in the paper), between 0 and two periods
    (uniform), or as far as chance has it (exponential: nobody can tell how soon the next will
    be); the mean is the period. The first comes after a random part of one, so that a team is
    not in step.
    """

    def __init__(
        self,
        period: float,
        probability: float,
        rng: np.random.Generator,
        distribution: Distribution = "fixed",
    ) -> None:
        self._period = period
        self._probability = probability
        self._rng = rng
        self._distribution = distribution
        self._next: float | None = None

    def due(self, t: float, *, permitted: bool) -> bool:
        """Tell whether to turn back at t, s. A time that passes while not permitted is lost."""
        if self._next is None:
            self._next = t + float(self._rng.uniform(0.0, self._period))
        if t < self._next:
            return False
        while self._next <= t:
            self._next += self._pause()
        return permitted and float(self._rng.random()) < self._probability

    def _pause(self) -> float:
        """Draw the time to the next one, s."""
        match self._distribution:
            case "fixed":
                return self._period
            case "uniform":
                return float(self._rng.uniform(0.0, 2.0 * self._period))
            case "exponential":
                return float(self._rng.exponential(self._period))

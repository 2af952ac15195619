"""Random reversal during Keep Going, which makes a patrol less predictable."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

Distribution = Literal["fixed", "uniform", "exponential"]


class RandomReversal:
    """Schedules times at which to turn back, each with some probability.

    The intervals between them are one period, s (fixed, as in the paper), uniform between 0 and
    two periods, or exponential (memoryless, so that the next time cannot be predicted); the mean
    is the period. The first interval is a random part of one, so that a team is not synchronized.
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

    @property
    def next_at(self) -> float:
        """The next scheduled time, s; minus infinity before the first step."""
        return -math.inf if self._next is None else self._next

    def due(self, t: float, *, permitted: bool) -> bool:
        """Return whether to turn back at t. A scheduled time that passes unpermitted is lost."""
        if self._next is None:
            self._next = t + float(self._rng.uniform(0.0, self._period))
        if t < self._next:
            return False
        while self._next <= t:
            self._next += self._interval()
        return permitted and float(self._rng.random()) < self._probability

    def _interval(self) -> float:
        """Draw the time from one scheduled time to the next, s."""
        match self._distribution:
            case "fixed":
                return self._period
            case "uniform":
                return float(self._rng.uniform(0.0, 2.0 * self._period))
            case "exponential":
                return float(self._rng.exponential(self._period))

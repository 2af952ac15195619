"""Random reversal during Keep Going, which makes a patrol less predictable."""

from __future__ import annotations

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

    def due(self, t: float, *, permitted: bool) -> bool:
        """Return whether to turn back at t. A scheduled time that passes unpermitted is lost."""
        if self._next is None:
            self._next = t + float(self._rng.uniform(0.0, self._period))
        if t < self._next:
            return False
        while self._next <= t:
            self._next += interval(self._period, self._distribution, self._rng)
        return permitted and float(self._rng.random()) < self._probability


def interval(period: float, distribution: Distribution, rng: np.random.Generator) -> float:
    """Draw the time from one scheduled time to the next, s; its mean is the period, s."""
    match distribution:
        case "fixed":
            return period
        case "uniform":
            return float(rng.uniform(0.0, 2.0 * period))
        case "exponential":
            return float(rng.exponential(period))

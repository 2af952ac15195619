"""Low-variance resampling (Probabilistic Robotics, table 4.4) and the effective sample size."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def effective_sample_size(weights: NDArray[np.float64]) -> float:
    """Return 1 / sum of squares of weights (n,) that sum to 1: n if all are equal, 1 if one is."""
    return 1.0 / float(weights @ weights)


def draw_low_variance(
    weights: NDArray[np.float64], count: int, rng: np.random.Generator
) -> NDArray[np.intp]:
    """Return (count,) indices drawn by weights (n,) summing to 1, with one random number.

    Each index comes up ``count * weight`` times, rounded up or down.
    """
    combs = (np.arange(count) + rng.random()) / count
    cumulative = np.cumsum(weights)
    # Rounding may leave the last sum below the last comb.
    return np.minimum(np.searchsorted(cumulative, combs, side="right"), len(weights) - 1)

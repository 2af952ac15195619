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
    # Number of the sampling points (i + random) / count below each cumulative weight.
    below = np.ceil(np.cumsum(weights) * count - rng.random()).astype(np.intp)
    np.minimum(below, count, out=below)
    below[-1] = count  # exactly, against rounding errors
    # A sampling point's index is the number of cumulative weights below it.
    return np.cumsum(np.bincount(below, minlength=count + 1)[:count])

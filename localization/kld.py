"""KLD sampling: number of particles by the spread of the belief.

Fox, "Adapting the sample size in particle filters through KLD-sampling", IJRR 22 (2003), eq. 13:
with n samples over k bins, the KL divergence between the samples' distribution and the true one
stays below ``max_divergence`` with the probability of ``quantile``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

BIN_XY = 0.1  # m; edge of a bin of the belief
BIN_THETA = 0.087  # rad; likewise
MAX_DIVERGENCE = 0.05  # bound on the KL divergence
QUANTILE = 2.33  # of the standard normal: 99 %
_AXIS_BITS = 21  # 2**20 bins of 0.1 m each way are 100 km


@dataclass(frozen=True, slots=True)
class SampleLimits:
    """Limits of the number of samples of a belief."""

    minimum: int
    maximum: int
    fixed: int | None = None
    """The number whatever the spread; None: between minimum and maximum."""


def sample_size(
    bins: int, max_divergence: float = MAX_DIVERGENCE, quantile: float = QUANTILE
) -> int:
    """Return Fox's number of samples for ``bins`` occupied bins (Wilson-Hilferty)."""
    if bins <= 1:
        return 1
    degrees = bins - 1
    spread = 2.0 / (9.0 * degrees)
    return math.ceil(
        degrees / (2.0 * max_divergence) * (1.0 - spread + math.sqrt(spread) * quantile) ** 3
    )


def bin_keys(particles: NDArray[np.float64], bin_xy: float, bin_theta: float) -> NDArray[np.int64]:
    """Return (n,) one packed key per particle (n, 3): equal keys share a bin of (x, y, theta)."""
    half = 1 << (_AXIS_BITS - 1)
    column = np.floor(particles[:, 0] * (1.0 / bin_xy)).astype(np.int64) + half
    row = np.floor(particles[:, 1] * (1.0 / bin_xy)).astype(np.int64) + half
    # Whole bins fill the turn, so that headings either side of pi meet.
    around = max(1, round(math.tau / bin_theta))
    sector = np.floor(particles[:, 2] * (around / math.tau))
    sector -= around * np.floor(sector / around)
    packed: NDArray[np.int64] = (column << _AXIS_BITS | row) << _AXIS_BITS | sector.astype(np.int64)
    return packed


def needed_samples(particles: NDArray[np.float64], limits: SampleLimits) -> int:
    """Return the number of samples for the belief drawn as particles (n, 3)."""
    if limits.fixed is not None:
        return limits.fixed
    keys = np.sort(bin_keys(particles, BIN_XY, BIN_THETA))
    bins = 1 + int(np.count_nonzero(keys[1:] != keys[:-1]))
    return min(max(sample_size(bins), limits.minimum), limits.maximum)

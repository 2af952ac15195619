"""Standard deviation of a pose, as perception uses it."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class PoseSigma(NamedTuple):
    """One sigma of a pose: of its position in the worst direction, m, and of its heading, rad."""

    xy: float
    theta: float

    @classmethod
    def of(cls, covariance: NDArray[np.float64]) -> PoseSigma:
        """Return the sigmas of a covariance (3, 3) of x, y, theta, m and rad."""
        xx, xy, yy = covariance[0, 0], covariance[0, 1], covariance[1, 1]
        largest = 0.5 * (xx + yy) + math.hypot(0.5 * (xx - yy), xy)
        return cls(math.sqrt(max(float(largest), 0.0)), math.sqrt(max(covariance[2, 2], 0.0)))


USUAL_POSE_SIGMA = PoseSigma(0.05, 0.0175)  # m, rad; of a pose without a covariance

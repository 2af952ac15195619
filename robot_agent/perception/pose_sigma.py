"""How far off a pose may be: what perception allows for."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class PoseSigma(NamedTuple):
    """One sigma of a pose: of its place in any direction, m, and of its heading, rad."""

    xy: float
    theta: float

    @classmethod
    def of(cls, covariance: NDArray[np.float64]) -> PoseSigma:
        """Return the worst of a covariance (3, 3) of x, y, theta."""
        xx, xy, yy = covariance[0, 0], covariance[0, 1], covariance[1, 1]
        largest = 0.5 * (xx + yy) + math.hypot(0.5 * (xx - yy), xy)
        return cls(math.sqrt(max(float(largest), 0.0)), math.sqrt(max(covariance[2, 2], 0.0)))


USUAL_POSE_SIGMA = PoseSigma(0.05, 0.0175)  # m, rad; of a pose of which no covariance is known

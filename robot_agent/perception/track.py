"""A track: one robot-sized thing followed over time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """Where a robot-sized thing is, and whether it is a teammate.

    x, y: centre of its outline, m, map frame. vx, vy: velocity, m/s, map frame. covariance:
    (2, 2) of the position, m^2. first_seen, last_seen: times of its first and latest detection,
    s. teammate: it has been seen moving.
    """

    id: int
    x: float
    y: float
    vx: float
    vy: float
    covariance: NDArray[np.float64]
    first_seen: float
    last_seen: float
    teammate: bool

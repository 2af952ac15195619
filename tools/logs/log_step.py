"""One scan of a log or recording, prepared for localization or mapping."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from maps.pose import Pose


@dataclass(frozen=True, slots=True, eq=False)
class LogStep:
    """One scan of a log with the odometry at it."""

    t: float
    odometry: Pose
    """odom_from_base at the scan."""
    points: NDArray[np.float64]
    """(n, 2) end points of the beams that returned, m, base_link."""
    reference: Pose | None
    """Reference map_from_base, None if unknown."""

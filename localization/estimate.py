"""The pose estimate, result of the localizer after a scan."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from localization.health import Health
from maps.pose import Pose


@dataclass(frozen=True, slots=True, eq=False)
class Estimate:
    """The pose at a scan, with covariance and health."""

    t: float
    """When the scan was measured."""
    pose: Pose
    """map_from_base at the scan."""
    odometry: Pose
    """odom_from_base at the scan."""
    covariance: NDArray[np.float64]
    """(3, 3) of x, y, theta in the map frame; m^2, m rad, rad^2."""
    health: Health
    particle_count: int
    effective_sample_size: float
    likelihood: float
    """Mean fit of the scan's beams to the map at the pose, 0..1; 0 if it has too few beams."""
    refined: bool
    """Whether the scan-to-map refinement was accepted."""

    def pose_at(self, odometry: Pose) -> Pose:
        """Return map_from_base at odometry, odom_from_base: the pose carried forward by it."""
        return self.pose.compose(self.odometry.between(odometry))

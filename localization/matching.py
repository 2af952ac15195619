"""What scans are matched with: a map's likelihood field, refinement and check, and a belief."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from localization.cluster import Cluster, best_cluster
from localization.filter import Belief
from localization.likelihood_field import LikelihoodField
from localization.refinement import Refined, Refinement
from localization.scan_check import Fit, ScanCheck
from maps.occupancy_map import OccupancyMap
from maps.pose import Pose


@dataclass(frozen=True, slots=True, eq=False)
class Hypothesis:
    """The pose of a belief after one scan, with its evidence."""

    cluster: Cluster
    refined: Refined | None
    pose: Pose
    """map_from_base."""
    fit: Fit | None
    """Of the scan at the pose; None if it has too few beams."""
    relocated: bool = False
    """Whether the scan fits only away from where the odometry puts the pose."""

    @property
    def covariance(self) -> NDArray[np.float64]:
        """(3, 3) of x, y, theta; m^2, m rad, rad^2."""
        return self.cluster.covariance if self.refined is None else self.refined.covariance


class Matching:
    """Matches scans with one map."""

    def __init__(self, occupancy: OccupancyMap, beams: int) -> None:
        """Prepare a map; beams: of a scan that particles are weighed by, at most."""
        self.field = LikelihoodField(occupancy, beams)
        self.refinement = Refinement(occupancy)
        self.check = ScanCheck(occupancy, self.refinement.surface)

    def best_hypothesis(self, belief: Belief, points: NDArray[np.float64]) -> Hypothesis:
        """Return the best cluster of a belief with its pose refined by a scan's points (m, 2)."""
        cluster = best_cluster(belief.particles, belief.weights)
        return self.refined(cluster, cluster.mean, cluster.covariance, points)

    def refined(
        self,
        cluster: Cluster,
        pose: Pose,
        covariance: NDArray[np.float64],
        points: NDArray[np.float64],
    ) -> Hypothesis:
        """Return the hypothesis of a cluster at a pose, refined within a covariance (3, 3)."""
        refined = self.refinement.refine(pose, covariance, points)
        pose = pose if refined is None else refined.pose
        return Hypothesis(cluster, refined, pose, self.check.fit(pose, points))

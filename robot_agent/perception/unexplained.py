"""The points of a scan that the map does not explain."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from maps.occupancy_map import FREE, OccupancyMap
from maps.pose import Pose
from robot_agent.perception.pose_sigma import USUAL_POSE_SIGMA, PoseSigma

# The map explains points nearer to an occupied cell than EXPLAINED_DISTANCE + range times
# EXPLAINED_ANGLE.
EXPLAINED_DISTANCE = 0.15  # m; map and position error
EXPLAINED_ANGLE = 0.035  # rad; heading error, two sigma


class UnexplainedPoints:
    """Finds laser points in known free space, farther from every wall than errors can place them.

    A wall's point is displaced by the pose's error, and by range times the heading error; the
    allowed distance therefore grows with range, and with the covariance of the pose estimate.
    Points in unknown cells or outside the map are never unexplained.
    """

    def __init__(self, occupancy: OccupancyMap, detection_range: float) -> None:
        """Prepare a map. detection_range: m; points farther away are never unexplained."""
        self._detection_range = detection_range
        clearance = np.where(occupancy.cells == FREE, occupancy.distance_field(), 0.0)
        # A rim of zeros stands for everything outside, so that one look-up per point suffices.
        self._clearance = np.pad(clearance, 1).astype(np.float64)
        self._per_metre = 1.0 / occupancy.resolution
        self._origin_x = occupancy.origin.x - occupancy.resolution
        self._origin_y = occupancy.origin.y - occupancy.resolution

    def mask(
        self,
        pose: Pose,
        points: NDArray[np.float64],
        ranges: NDArray[np.float64],
        sigma: PoseSigma | None = None,
    ) -> NDArray[np.bool_]:
        """Return (n,) which points (n, 2), m, base_link, the map does not explain.

        pose: map_from_base; sigma: of the pose, None for the usual one. ranges: (n,) m, the points'
        distances from base_link.
        """
        rows, cols = self._cells(pose, points)
        distance, angle = EXPLAINED_DISTANCE, EXPLAINED_ANGLE
        if sigma is not None:
            # Two sigma, as far as they exceed the usual ones, which the constants include.
            distance += 2.0 * max(sigma.xy - USUAL_POSE_SIGMA.xy, 0.0)
            angle += 2.0 * max(sigma.theta - USUAL_POSE_SIGMA.theta, 0.0)
        allowed = distance + angle * ranges
        unexplained: NDArray[np.bool_] = self._clearance[rows, cols] > allowed
        unexplained &= ranges <= self._detection_range
        return unexplained

    def _cells(
        self, pose: Pose, points: NDArray[np.float64]
    ) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Return (rows, cols) in the padded grid of points in base_link, clipped to its rim."""
        c, s = math.cos(pose.theta) * self._per_metre, math.sin(pose.theta) * self._per_metre
        x, y = points[:, 0], points[:, 1]
        height, width = self._clearance.shape
        col = (pose.x - self._origin_x) * self._per_metre + c * x - s * y
        row = (pose.y - self._origin_y) * self._per_metre + s * x + c * y
        # Truncation equals floor: whatever is below 1 ends in the rim, row or column 0.
        return (
            np.minimum(np.maximum(row, 0.0), height - 1).astype(np.intp),
            np.minimum(np.maximum(col, 0.0), width - 1).astype(np.intp),
        )

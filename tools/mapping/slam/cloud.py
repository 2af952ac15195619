"""Point clouds for scan matching: points of one or several keyframes."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from maps.pose import Pose
from tools.mapping.slam.keyframe import Keyframe


class Cloud:
    """Points in one frame; those with a known surface direction can be searched."""

    def __init__(self, points: NDArray[np.float64], normals: NDArray[np.float64]) -> None:
        """Take points (n, 2), m, and normals (n, 2), nan where unknown."""
        self.points = points
        known = np.isfinite(normals[:, 0])
        self.surface, self.normals = points[known], normals[known]
        self._tree = KDTree(self.surface) if len(self.surface) else None

    def nearest(
        self, points: NDArray[np.float64], reach: float
    ) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
        """Return distance, m, and index of the nearest surface point; inf beyond ``reach``, m."""
        if self._tree is None:
            return np.full(len(points), np.inf), np.zeros(len(points), dtype=np.intp)
        distance, index = self._tree.query(points, distance_upper_bound=reach)
        return distance, index


def join(frames: Iterable[tuple[Pose, Keyframe]]) -> Cloud:
    """Return keyframes' points in one frame; each pose is frame_from_laser."""
    points, normals = [], []
    for pose, frame in frames:
        rotation = rotation_of(pose.theta)
        points.append(frame.points @ rotation.T + pose[:2])
        normals.append(frame.normals @ rotation.T)
    return Cloud(np.concatenate(points), np.concatenate(normals))


def rotation_of(theta: float) -> NDArray[np.float64]:
    """Return the (2, 2) matrix of a rotation by theta rad."""
    c, s = np.cos(theta), np.sin(theta)
    return np.array([[c, -s], [s, c]])

"""Point-to-line alignment of a scan with a cloud (Censi, ICRA 2008), with its information matrix.

A corridor's walls say nothing about the place along it; the information matrix says so, and the
pose graph then takes that from elsewhere.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from maps.pose import Pose, wrap_angle
from tools.mapping.slam.cloud import Cloud, rotation_of

_SIGMA = 0.03  # m; of a laser point from the line through its neighbours
_REACHES = (0.6, 0.4, 0.25)  # m; how far apart the same surface is taken for, shrinking
_LAST_REACH = 0.15
_MAX_STEPS = 20
_CONVERGED = 1e-4  # m and rad
_ARM = 3.0  # m; a turn of a radian moves the points about this far
_TOLD = 0.03  # a direction with less than this share of the best one's information is not told
_MIN_PAIRS = 20
# What is left when the points' noise has averaged out: a scan taken while moving, a cloud not
# quite in its place. Standard deviations, m, m, rad.
_FLOOR = np.diag([0.015, 0.015, 0.004])


@dataclass(frozen=True, slots=True, eq=False)
class Alignment:
    """Where a scan lies in a cloud's frame."""

    pose: Pose
    """cloud_from_scan."""
    information: NDArray[np.float64]
    """(3, 3) inverse covariance of x, y, theta in the cloud's frame: 1/m^2, 1/rad^2."""
    share: float
    """Share of the scan's points that lie on the cloud's surfaces."""


def align(points: NDArray[np.float64], cloud: Cloud, guess: Pose) -> Alignment | None:
    """Move a scan's points (n, 2) onto a cloud's surfaces, Gauss-Newton on robust residuals.

    None if too few points have a counterpart.
    """
    pose = guess
    for step in range(_MAX_STEPS):
        reach = _REACHES[step] if step < len(_REACHES) else _LAST_REACH
        equations = _linearize(points, cloud, pose, reach)
        if equations is None:
            return None
        hessian, gradient, _ = equations
        change = -np.linalg.pinv(_told(hessian), rcond=1e-9, hermitian=True) @ gradient
        pose = Pose(
            pose.x + float(change[0]),
            pose.y + float(change[1]),
            wrap_angle(pose.theta + float(change[2])),
        )
        if step >= len(_REACHES) and np.abs(change).max() < _CONVERGED:
            break
    equations = _linearize(points, cloud, pose, _LAST_REACH)
    if equations is None:
        return None
    return Alignment(pose, _floored(_told(equations[0])), equations[2] / len(points))


def _told(hessian: NDArray[np.float64]) -> NDArray[np.float64]:
    """Leave out of a Hessian what only the noise of the normals tells: the way along a corridor."""
    scale = np.array([1.0, 1.0, 1.0 / _ARM])
    values, vectors = np.linalg.eigh(hessian * np.outer(scale, scale))
    values[values < _TOLD * values[-1]] = 0.0
    told = (vectors * values) @ vectors.T
    return np.asarray(told / np.outer(scale, scale))


def _linearize(
    points: NDArray[np.float64], cloud: Cloud, pose: Pose, reach: float
) -> tuple[NDArray[np.float64], NDArray[np.float64], float] | None:
    """Return Hessian and gradient of the weighted squares, and the number of pairs."""
    rotated = points @ rotation_of(pose.theta).T
    distance, index = cloud.nearest(rotated + pose[:2], reach)
    paired = np.isfinite(distance)
    if np.count_nonzero(paired) < _MIN_PAIRS:
        return None
    rotated, index = rotated[paired], index[paired]
    normals = cloud.normals[index]
    residuals = np.sum((rotated + pose[:2] - cloud.surface[index]) * normals, axis=1)
    turn = normals[:, 1] * rotated[:, 0] - normals[:, 0] * rotated[:, 1]
    jacobian = np.column_stack((normals, turn)) / _SIGMA
    residuals = residuals / _SIGMA
    weights = 1.0 / (1.0 + residuals**2 / 4.0)  # Cauchy, at two sigma
    weighted = jacobian * weights[:, None]
    return weighted.T @ jacobian, weighted.T @ residuals, float(np.count_nonzero(paired))


def _floored(information: NDArray[np.float64]) -> NDArray[np.float64]:
    """Add the floor's covariance to a possibly singular information matrix."""
    floor = np.linalg.inv(_FLOOR @ _FLOOR)
    added = information - information @ np.linalg.solve(information + floor, information)
    return np.asarray(0.5 * (added + added.T))

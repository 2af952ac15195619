"""Point-to-line alignment of a scan with a cloud (Censi, ICRA 2008), with its information matrix.

A corridor's walls do not determine the position along it: the information matrix is singular in
that direction, and the pose graph determines it by other edges.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from maps.pose import Pose, wrap_angle
from tools.mapping.slam.cloud import Cloud, rotation_of

_SIGMA = 0.03  # m; of a laser point from the line through its neighbours
_REACHES = (0.6, 0.4, 0.25)  # m; correspondence distances of successive steps
_LAST_REACH = 0.15
_MAX_STEPS = 20
_CONVERGED = 1e-4  # m and rad
_ARM = 3.0  # m; weight of a radian in metres: typical distance of the points
_MIN_INFORMATION = 0.03  # share of the best direction's; less is not observable
_MIN_PAIRS = 20
# Errors that do not average out over the points: motion during the scan, errors of the cloud's
# poses. Standard deviations, m, m, rad.
_FLOOR = np.diag([0.015, 0.015, 0.004])


@dataclass(frozen=True, slots=True, eq=False)
class Alignment:
    """Pose of a scan in a cloud's frame."""

    pose: Pose
    """cloud_from_scan."""
    information: NDArray[np.float64]
    """(3, 3) inverse covariance of x, y, theta in the cloud's frame: 1/m^2, 1/rad^2."""
    share: float
    """Share of the scan's points with a counterpart on the cloud's surfaces."""


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
        change = -np.linalg.pinv(_observable(hessian), rcond=1e-9, hermitian=True) @ gradient
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
    return Alignment(pose, _floored(_observable(equations[0])), equations[2] / len(points))


def _observable(hessian: NDArray[np.float64]) -> NDArray[np.float64]:
    """Zero the weak eigenvalues of a Hessian: they are noise, as along a corridor."""
    scale = np.array([1.0, 1.0, 1.0 / _ARM])
    values, vectors = np.linalg.eigh(hessian * np.outer(scale, scale))
    values[values < _MIN_INFORMATION * values[-1]] = 0.0
    observable = (vectors * values) @ vectors.T
    return np.asarray(observable / np.outer(scale, scale))


def _linearize(
    points: NDArray[np.float64], cloud: Cloud, pose: Pose, reach: float
) -> tuple[NDArray[np.float64], NDArray[np.float64], float] | None:
    """Return Hessian, gradient of the weighted squares and number of pairs; None: too few."""
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

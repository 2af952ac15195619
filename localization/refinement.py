"""Scan-to-map refinement of the pose estimate.

Gauss-Newton (iteratively re-weighted least squares) on the interpolated distance from each end
point to the mapped surface, with a Welsch kernel so that people and teammates have no influence,
and the particles' covariance as prior, so that a direction the scan does not determine (along a
bare corridor) keeps the filter's value.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from localization.distance_surface import DistanceSurface
from localization.likelihood_field import spread_evenly
from maps.occupancy_map import OccupancyMap
from maps.pose import Pose, wrap_angle

MAX_POINTS = 180  # of a scan, spread evenly over it
STEPS = 4  # of Gauss-Newton, at most
INDEPENDENT_POINTS = 60.0  # that the points of one scan count as together
SIGMA = 0.05  # m; of an end point's distance from the mapped surface
COVARIANCE_POINTS = 6.0  # as INDEPENDENT_POINTS, for the stated covariance
MIN_RESIDUAL = 0.01  # m; the laser's own noise
KERNEL = 0.15  # m; end points farther from the map than this have little weight
MIN_XY = 0.05  # m; minimum sigma of the cloud: that of a few hundred samples is not more precise
MIN_THETA = 0.025  # rad; likewise
LIMIT_XY = 0.3  # m from the cloud's mean; a refinement farther away is rejected
LIMIT_THETA = 0.15  # rad; likewise
_CLOUD_SIGMAS = 4.0  # a refinement farther than this from the cloud's mean is rejected
_CONVERGED = 3e-3  # m and rad
TOO_FEW_POINTS = 10


@dataclass(frozen=True, slots=True, eq=False)
class Refined:
    """A refined pose."""

    pose: Pose
    """map_from_base."""
    covariance: NDArray[np.float64]
    """(3, 3) of x, y, theta, m and rad: given scan and particles."""


@dataclass(frozen=True, slots=True, eq=False)
class _Misfit:
    """Cost of a scan at a pose, linearized."""

    cost: float
    gradient: NDArray[np.float64]
    """(3,) of the cost by x, y, theta."""
    curvature: NDArray[np.float64]
    """(3, 3), Gauss-Newton's."""
    residual: float
    """Root mean square distance of the end points from the map, weighted by the kernel, m."""


class Refinement:
    """Refines poses against one map."""

    def __init__(
        self,
        occupancy: OccupancyMap,
        *,
        limit_xy: float = LIMIT_XY,
        limit_theta: float = LIMIT_THETA,
    ) -> None:
        """Prepare a map. limit_xy, limit_theta: maximum correction of a pose, m and rad."""
        self._limit_xy, self._limit_theta = limit_xy, limit_theta
        self._min_covariance = np.diag(np.square((MIN_XY, MIN_XY, MIN_THETA)))
        self.surface = DistanceSurface(occupancy)

    def refine(
        self, mean: Pose, covariance: NDArray[np.float64], points: NDArray[np.float64]
    ) -> Refined | None:
        """Return the refined map_from_base; None if it does not improve or is outside the limits.

        mean, covariance (3, 3): the particle cloud's. points (m, 2): end points in base_link, m;
        None is returned for too few as well.
        """
        ends = as_complex(spread_evenly(points, MAX_POINTS))
        if len(ends) < TOO_FEW_POINTS:
            return None
        prior = np.linalg.inv(covariance + self._min_covariance)
        away: NDArray[np.float64] = np.zeros(3)
        best, best_misfit = away, None
        start_cost = best_cost = math.inf
        for step in range(STEPS + 1):
            misfit = self._misfit(_moved(mean, away), ends)
            pull_back = prior @ away
            cost = misfit.cost + 0.5 * float(away @ pull_back)
            if step == 0:
                start_cost = cost
            if cost < best_cost:
                best_cost, best, best_misfit = cost, away, misfit
            change = _solve(misfit.curvature + prior, -(misfit.gradient + pull_back))
            if np.abs(change).max() < _CONVERGED:
                break
            away = away + change
        if best_cost >= start_cost or best_misfit is None or not self._is_near(best, prior):
            return None
        return Refined(_moved(mean, best), self._covariance(best_misfit, prior, len(ends)))

    def _misfit(self, pose: Pose, ends: NDArray[np.complex64]) -> _Misfit:
        arms = turned(ends, pose)
        slope_x, slope_y, distance = self.surface.sample(pose, arms)
        # A rotation of the robot moves an end point at right angles to its lever arm.
        slope_theta = slope_y * arms.real - slope_x * arms.imag
        rows = np.array((slope_x, slope_y, slope_theta, distance))
        pull = np.exp(distance * distance * np.float32(-0.5 / KERNEL**2))
        moments = ((rows * pull) @ rows.T).astype(np.float64)
        total = float(pull.sum())
        scale = self._information_per_point(len(ends))
        return _Misfit(
            cost=scale * KERNEL**2 * (len(ends) - total),
            gradient=scale * moments[:3, 3],
            curvature=scale * moments[:3, :3],
            residual=math.sqrt(moments[3, 3] / max(total, 1.0)),
        )

    def _covariance(
        self, misfit: _Misfit, prior: NDArray[np.floating[Any]], count: int
    ) -> NDArray[np.float64]:
        """Return the covariance (3, 3) given the scan at its best pose and the cloud.

        The variance of the end points is taken from their residual (a-posteriori variance of least
        squares): where the map is blurred, the covariance is larger. Their errors are correlated,
        so that a whole scan counts as a few independent points.
        """
        residual = max(misfit.residual, MIN_RESIDUAL)
        information = min(1.0, COVARIANCE_POINTS / count) / residual**2
        per_point = misfit.curvature / self._information_per_point(count)
        covariance = np.asarray(np.linalg.inv(per_point * information + prior), dtype=np.float64)
        return 0.5 * (covariance + covariance.T)  # single precision moments are not quite symmetric

    def _information_per_point(self, count: int) -> float:
        return min(1.0, INDEPENDENT_POINTS / count) / SIGMA**2

    def _is_near(self, away: NDArray[np.float64], information: NDArray[np.floating[Any]]) -> bool:
        return (
            math.hypot(away[0], away[1]) <= self._limit_xy
            and abs(away[2]) <= self._limit_theta
            and float(away @ information @ away) <= _CLOUD_SIGMAS**2
        )


def as_complex(points: NDArray[np.float64]) -> NDArray[np.complex64]:
    """Return points (m, 2) as x + iy (m,): a rotation is then one multiplication."""
    return points.astype(np.float32, order="C").view(np.complex64)[:, 0]


def turned(ends: NDArray[np.complex64], pose: Pose) -> NDArray[np.complex64]:
    """Return (m,) end points relative to the robot, rotated to the map's axes, m."""
    return ends * np.complex64(complex(math.cos(pose.theta), math.sin(pose.theta)))


def _moved(pose: Pose, away: NDArray[np.float64]) -> Pose:
    x, y, theta = away.tolist()
    return Pose(pose.x + x, pose.y + y, wrap_angle(pose.theta + theta))


def _solve(matrix: NDArray[np.float64], right: NDArray[np.float64]) -> NDArray[np.float64]:
    """Solve a symmetric positive definite 3x3 system (cv2 is faster than NumPy at this size)."""
    _, solution = cv2.solve(matrix, right[:, np.newaxis], flags=cv2.DECOMP_CHOLESKY)
    return np.asarray(solution[:, 0], dtype=np.float64)

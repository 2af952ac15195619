"""Clusters of a weighted particle set; the heaviest one gives the pose estimate."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from localization.kld import bin_keys
from maps.pose import Pose

_BIN_XY = 0.5  # m
_BIN_THETA = math.radians(30.0)
_REACH_XY = 1.0  # m; particles this near to the cluster's mean belong to it
_REACH_THETA = math.radians(45.0)
_CANDIDATES = 4  # bins to grow a cluster from
_TIGHT = 0.25  # m; a set with a smaller spread is one cluster


@dataclass(frozen=True, slots=True, eq=False)
class Cluster:
    """Particles near one pose."""

    mean: Pose
    """Weighted mean (map_from_base)."""
    covariance: NDArray[np.float64]
    """(3, 3) of x, y, theta in the map frame; m^2, m rad, rad^2."""
    share: float
    """Share of the whole weight, 0..1."""

    @property
    def spread(self) -> float:
        """Standard deviation of the position along its worst direction, m."""
        half_trace = 0.5 * (self.covariance[0, 0] + self.covariance[1, 1])
        half_difference = 0.5 * (self.covariance[0, 0] - self.covariance[1, 1])
        return math.sqrt(half_trace + math.hypot(half_difference, self.covariance[0, 1]))


def best_cluster(particles: NDArray[np.float64], weights: NDArray[np.float64]) -> Cluster:
    """Return the heaviest cluster of particles (n, 3) with weights (n,) summing to 1."""
    best = _moments(particles, weights, 1.0)
    if best.spread < _TIGHT and best.covariance[2, 2] < _TIGHT**2:
        return best
    best_share = 0.0
    for cluster, left in islice(_clusters(particles, weights), _CANDIDATES):
        if cluster.share > best_share:
            best, best_share = cluster, cluster.share
        if left <= best_share:
            break
    return best


def heavy_clusters(
    particles: NDArray[np.float64], weights: NDArray[np.float64], limit: int
) -> list[Cluster]:
    """Return at most ``limit`` heavy clusters of particles (n, 3); weights (n,) sum to 1."""
    return [cluster for cluster, _ in islice(_clusters(particles, weights), limit)]


def _clusters(
    particles: NDArray[np.float64], weights: NDArray[np.float64]
) -> Iterator[tuple[Cluster, float]]:
    """Yield a cluster round each of the heaviest bins, with the weight outside of all so far.

    The heaviest bin need not be of the heaviest cluster, which may extend over several bins.
    """
    _, members = np.unique(bin_keys(particles, _BIN_XY, _BIN_THETA), return_inverse=True)
    outside = weights.copy()
    left = 1.0
    while left > 0.0:
        heaviest = members == np.bincount(members, outside).argmax()
        cluster = _grown(particles, weights, heaviest)
        outside[heaviest | near(particles, cluster.mean)] = 0.0
        left = float(outside.sum())
        yield cluster, left


def _grown(
    particles: NDArray[np.float64], weights: NDArray[np.float64], seed: NDArray[np.bool_]
) -> Cluster:
    """Return the cluster grown from the particles of one bin, which may be at its edge."""
    cluster = _members_of(particles, weights, seed)
    for _ in range(2):
        members = near(particles, cluster.mean)
        if not weights[members].any():
            break
        cluster = _members_of(particles, weights, members)
    return cluster


def near(particles: NDArray[np.float64], middle: Pose) -> NDArray[np.bool_]:
    """Return (n,) which of particles (n, 3) are within a cluster's reach of ``middle``."""
    distance = np.hypot(particles[:, 0] - middle.x, particles[:, 1] - middle.y)
    turn = np.abs(_wrap(particles[:, 2] - middle.theta))
    within: NDArray[np.bool_] = (distance < _REACH_XY) & (turn < _REACH_THETA)
    return within


def _members_of(
    particles: NDArray[np.float64], weights: NDArray[np.float64], chosen: NDArray[np.bool_]
) -> Cluster:
    share = float(weights[chosen].sum())
    return _moments(particles[chosen], weights[chosen] / share, share)


def _moments(particles: NDArray[np.float64], weights: NDArray[np.float64], share: float) -> Cluster:
    """Return weighted mean and covariance; weights sum to 1. The mean heading is circular."""
    heading = particles[:, 2].astype(np.float32)  # precise enough here, and much faster
    middle = math.atan2(weights @ np.sin(heading), weights @ np.cos(heading))
    away = np.empty((3, len(particles)))
    x, y = float(weights @ particles[:, 0]), float(weights @ particles[:, 1])
    np.subtract(particles[:, 0], x, out=away[0])
    np.subtract(particles[:, 1], y, out=away[1])
    away[2] = _wrap(particles[:, 2] - middle)
    mean = Pose(x, y, middle)
    covariance = (away * weights) @ away.T
    return Cluster(mean, covariance, share)


def _wrap(angles: NDArray[np.float64]) -> NDArray[np.float64]:
    wrapped: NDArray[np.float64] = angles - math.tau * np.rint(angles / math.tau)
    return wrapped

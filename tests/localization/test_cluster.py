"""The best cluster: where most of the weight is, with its mean, covariance and share."""

from __future__ import annotations

import math

import numpy as np
import pytest

from localization.cluster import best_cluster, heavy_clusters

RNG_SEED = 4


def test_tight_particle_set_is_one_cluster() -> None:
    rng = np.random.default_rng(RNG_SEED)
    particles = rng.normal((2.0, -3.0, 0.5), (0.1, 0.05, 0.02), (5000, 3))
    cluster = best_cluster(particles, np.full(5000, 1 / 5000))
    assert cluster.mean == pytest.approx((2.0, -3.0, 0.5), abs=0.01)
    assert np.sqrt(np.diag(cluster.covariance)) == pytest.approx((0.1, 0.05, 0.02), rel=0.05)
    assert cluster.share == 1.0
    assert cluster.spread == pytest.approx(0.1, rel=0.05)


def test_heavier_of_two_clouds_is_the_best_cluster() -> None:
    rng = np.random.default_rng(RNG_SEED)
    many = rng.normal((0.0, 0.0, 0.0), 0.05, (3000, 3))
    heavy = rng.normal((6.0, 2.0, 1.0), 0.05, (1000, 3))
    weights = np.concatenate((np.full(3000, 0.3 / 3000), np.full(1000, 0.7 / 1000)))
    cluster = best_cluster(np.vstack((many, heavy)), weights)
    assert cluster.mean == pytest.approx((6.0, 2.0, 1.0), abs=0.01)
    assert cluster.share == pytest.approx(0.7)
    assert cluster.spread < 0.07


def test_same_place_other_heading_is_another_cluster() -> None:
    rng = np.random.default_rng(RNG_SEED)
    forth = rng.normal((1.0, 1.0, 0.0), 0.03, (600, 3))
    back = rng.normal((1.0, 1.0, 3.0), 0.03, (400, 3))
    cluster = best_cluster(np.vstack((forth, back)), np.full(1000, 1e-3))
    assert cluster.mean.theta == pytest.approx(0.0, abs=0.01)
    assert cluster.share == pytest.approx(0.6)


def test_heading_is_averaged_round_the_circle() -> None:
    particles = np.array([[0, 0, math.pi - 0.1], [0, 0, -math.pi + 0.1]], dtype=np.float64)
    cluster = best_cluster(particles, np.array([0.5, 0.5]))
    assert abs(cluster.mean.theta) == pytest.approx(math.pi)
    assert cluster.covariance[2, 2] == pytest.approx(0.01)


def test_spread_is_along_the_worst_direction() -> None:
    along = np.linspace(-0.2, 0.2, 101)
    particles = np.column_stack((along, along, np.zeros(101)))
    cluster = best_cluster(particles, np.full(101, 1 / 101))
    assert cluster.spread == pytest.approx(math.sqrt(2) * along.std())


def test_heavy_clusters_come_apart_and_heaviest_first() -> None:
    rng = np.random.default_rng(1)
    places = np.array([(0.0, 0.0, 0.0), (5.0, 0.0, 1.0), (0.0, 5.0, -2.0)])
    particles = np.repeat(places, 100, axis=0) + 0.05 * rng.standard_normal((300, 3))
    weights = np.repeat((0.2, 0.5, 0.3), 100) / 100
    clusters = heavy_clusters(particles, weights, 8)
    assert [round(cluster.share, 6) for cluster in clusters] == [0.5, 0.3, 0.2]
    assert [cluster.share for cluster in heavy_clusters(particles, weights, 2)] == [
        cluster.share for cluster in clusters[:2]
    ]
    for cluster, place in zip(clusters, places[[1, 2, 0]], strict=True):
        assert np.allclose(cluster.mean, place, atol=0.05)

"""Pose graph: known optima, and outliers that lose their weight."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from maps.pose import Pose
from tools.mapping.slam.pose_graph import Edge, optimize

INFORMATION = np.diag([1e4, 1e4, 1e5])


def ring(n: int = 24, radius: float = 4.0) -> list[Pose]:
    """Return poses once round a circle, heading along it, the first at the origin."""
    turns = [math.tau * i / n for i in range(n)]
    circle = [
        Pose(radius * math.sin(turn), radius * (1.0 - math.cos(turn)), turn) for turn in turns
    ]
    return [circle[0], *(circle[0].between(pose) for pose in circle[1:])]


def drifting_edges(truth: list[Pose], turn: float) -> list[Edge]:
    """Return edges round the ring, each turned too far."""
    steps = [a.between(b) for a, b in pairwise(truth)]
    return [
        Edge(i, i + 1, Pose(step.x, step.y, step.theta + turn), INFORMATION / 100.0, robust=False)
        for i, step in enumerate(steps)
    ]


def chained(edges: list[Edge]) -> list[Pose]:
    poses = [Pose(0.0, 0.0, 0.0)]
    for edge in edges:
        poses.append(poses[-1].compose(edge.pose))
    return poses


def worst(poses: list[Pose], truth: list[Pose]) -> float:
    return max(math.dist(a[:2], b[:2]) for a, b in zip(poses, truth, strict=True))


def test_two_edges_of_one_step_give_the_weighted_mean() -> None:
    edges = [
        Edge(0, 1, Pose(1.0, 0.0, 0.1), INFORMATION, robust=False),
        Edge(0, 1, Pose(2.0, 0.4, 0.5), 3.0 * INFORMATION, robust=False),
    ]
    start, end = optimize([Pose(5.0, 5.0, math.pi / 2), Pose(0.0, 0.0, 0.0)], edges)
    assert start == pytest.approx((5.0, 5.0, math.pi / 2))
    # A quarter of the first and three of the second, in the start's frame.
    assert start.between(end) == pytest.approx((1.75, 0.3, 0.4), abs=1e-4)


def test_exact_edges_give_zero_error_across_pi() -> None:
    truth = ring()
    edges = [*drifting_edges(truth, 0.0), Edge(23, 0, truth[23].between(truth[0]), INFORMATION)]
    rough = [Pose(p.x + 0.1 * math.sin(i), p.y - 0.1, p.theta) for i, p in enumerate(truth)]
    poses = optimize([truth[0], *rough[1:]], edges)
    assert worst(poses, truth) < 1e-4


def test_loop_edge_removes_the_drift_of_a_ring() -> None:
    truth = ring()
    edges = drifting_edges(truth, math.radians(2.0))
    drifted = chained(edges)
    loop = Edge(0, 23, truth[23], INFORMATION)
    closed = optimize(drifted, [*edges, loop])
    assert worst(drifted, truth) > 1.5
    assert worst(closed, truth) < 0.2


def test_wrong_robust_loop_loses_its_weight() -> None:
    truth = ring()
    edges = drifting_edges(truth, math.radians(0.3))
    right = [Edge(i, i + 12, truth[i].between(truth[i + 12]), INFORMATION) for i in range(12)]
    wrong = Edge(2, 20, Pose(3.0, -3.0, 1.0), INFORMATION)
    poses = optimize(chained(edges), [*edges, *right, wrong])
    assert worst(poses, truth) < 0.05
    # The same edge without robust weighting distorts everything.
    believed = Edge(2, 20, wrong.pose, INFORMATION, robust=False)
    assert worst(optimize(chained(edges), [*edges, *right, believed]), truth) > 0.5

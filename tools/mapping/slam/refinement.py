"""Refinement: pairwise alignment of all near scans, and one pose graph of all pairs.

After Lu and Milios, "Globally consistent range scan alignment" (1997): once the loops are closed,
every pair of scans of the same surfaces gives a measurement of their relative pose.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from maps.pose import Pose
from tools.mapping.slam.alignment import align
from tools.mapping.slam.chain import close
from tools.mapping.slam.cloud import Cloud
from tools.mapping.slam.keyframe import Keyframe
from tools.mapping.slam.pose_graph import Edge, optimize

_NEAR = 3.0  # m between two scans' lasers
_MAX_PARTNERS = 8  # of each scan, the nearest ones
_MIN_SHARE = 0.35
_CORRECTION = (0.3, math.radians(4.0))  # m, rad; more is a wrong match


@dataclass(frozen=True, slots=True, eq=False)
class Refinement:
    """Poses, and the pairs of scans from which they were computed."""

    poses: list[Pose]
    pairs: list[Edge]

    def disagreement(self) -> float:
        """Return the median distance between pairs' measured relative poses and the poses, m."""
        off = [
            math.dist(pair.pose[:2], self.poses[pair.start].between(self.poses[pair.end])[:2])
            for pair in self.pairs
        ]
        return float(np.median(off)) if off else math.nan


def refine(
    frames: Sequence[Keyframe],
    poses: Sequence[Pose],
    edges: Sequence[Edge],
    progress: Callable[[float], None],
) -> Refinement:
    """Return the poses refined by all pairs.

    edges: those of the chain and the loops, for scans without a pair. progress: called with the
    number of scans done.
    """
    clouds = [Cloud(frame.points, frame.normals) for frame in frames]
    pairs: list[Edge] = []
    for index, partners in enumerate(_partners(poses)):
        pairs += _pairs(frames, clouds, poses, index, partners)
        progress(index)
    return Refinement(optimize(poses, [*edges, *pairs]), pairs)


def _partners(poses: Sequence[Pose]) -> list[list[int]]:
    """Return for each scan the nearest earlier ones."""
    places = np.array([pose[:2] for pose in poses])
    near = KDTree(places).query_ball_point(places, _NEAR)
    partners = []
    for index, found in enumerate(near):
        earlier = np.array([other for other in found if other < index], dtype=int)
        apart = np.hypot(*(places[earlier] - places[index]).T)
        partners.append([int(other) for other in earlier[np.argsort(apart)[:_MAX_PARTNERS]]])
    return partners


def _pairs(
    frames: Sequence[Keyframe],
    clouds: Sequence[Cloud],
    poses: Sequence[Pose],
    index: int,
    partners: Sequence[int],
) -> list[Edge]:
    """Align one scan with each of its partners; return the accepted edges."""
    edges = []
    for partner in partners:
        guess = poses[partner].between(poses[index])
        found = align(frames[index].points, clouds[partner], guess)
        if found is None or found.share < _MIN_SHARE:
            continue
        if close(guess, found.pose, _CORRECTION):
            edges.append(Edge(partner, index, found.pose, found.information))
    return edges

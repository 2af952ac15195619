"""Refinement: all scans near each other aligned pairwise, and one graph of all of it.

After Lu and Milios, "Globally consistent range scan alignment" (1997): once the loops are closed,
every pair of scans that see the same surfaces is a measurement of their relative pose.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from scipy.spatial import KDTree

from maps.pose import Pose
from tools.slam.alignment import align
from tools.slam.chain import close
from tools.slam.cloud import Cloud
from tools.slam.keyframe import Keyframe
from tools.slam.pose_graph import Edge, optimize

ROUNDS = 2
_NEAR = 3.0  # m between two scans' lasers
_MOST_PARTNERS = 10  # of each scan, the nearest ones
_LEAST_SHARE = 0.35
_CORRECTION = (0.3, math.radians(4.0))  # m, rad; more is a wrong match


def refine(
    frames: Sequence[Keyframe],
    poses: Sequence[Pose],
    odometry: Sequence[Edge],
    progress: Callable[[float], None],
) -> tuple[list[Pose], int]:
    """Return better poses, and the number of pairs they rest on.

    odometry: edges that hold scans that match nothing. progress: called with the number of scans
    done, ROUNDS times over.
    """
    clouds = [Cloud(frame.points, frame.normals) for frame in frames]
    refined = list(poses)
    edges: list[Edge] = []
    for number in range(ROUNDS):
        edges = []
        for index, partners in enumerate(_partners(refined)):
            edges += _pairs(frames, clouds, refined, index, partners)
            progress(number * len(frames) + index)
        refined = optimize(refined, [*odometry, *edges])
    return refined, len(edges)


def _partners(poses: Sequence[Pose]) -> list[list[int]]:
    """Return for each scan the nearest earlier ones."""
    places = np.array([pose[:2] for pose in poses])
    near = KDTree(places).query_ball_point(places, _NEAR)
    partners = []
    for index, found in enumerate(near):
        earlier = np.array([other for other in found if other < index], dtype=int)
        apart = np.hypot(*(places[earlier] - places[index]).T)
        partners.append([int(other) for other in earlier[np.argsort(apart)[:_MOST_PARTNERS]]])
    return partners


def _pairs(
    frames: Sequence[Keyframe],
    clouds: Sequence[Cloud],
    poses: Sequence[Pose],
    index: int,
    partners: Sequence[int],
) -> list[Edge]:
    """Align one scan with each of its partners; keep what fits."""
    edges = []
    for partner in partners:
        guess = poses[partner].between(poses[index])
        found = align(frames[index].points, clouds[partner], guess)
        if found is None or found.share < _LEAST_SHARE:
            continue
        if close(guess, found.pose, _CORRECTION):
            edges.append(Edge(partner, index, found.pose, found.information))
    return edges

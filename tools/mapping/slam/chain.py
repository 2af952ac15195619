"""The chain: each keyframe's pose by matching it with those just before it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from maps.pose import Pose, wrap_angle
from tools.mapping.slam.alignment import Alignment, align
from tools.mapping.slam.cloud import Cloud, join
from tools.mapping.slam.correlation import search
from tools.mapping.slam.keyframe import Keyframe
from tools.mapping.slam.pose_graph import Edge

_BEFORE = 8  # keyframes matched with together
_MIN_SCORE = 0.4  # least score of a search to be refined
_MIN_SHARE = 0.25  # least share of points on surfaces of an accepted alignment
_NEAR_PEAK = (
    0.3,
    math.radians(5.0),
)  # m, rad; an alignment farther off the peak has slid
_LARGEST_TURN = math.radians(45.0)
_SURE_SHARE = 0.6  # share of an alignment that is looked for no farther
_MISSED_TURN = math.radians(90.0)
_MISSED_SIGMAS = 4.0  # of the odometry's heading; more is a turn that the wheels missed
_LARGEST_STEP = 1.5  # m


def odometry_edge(start: int, end: int, frames: Sequence[Keyframe]) -> Edge:
    """Return the odometry's edge between two keyframes, with a covariance for slipping wheels."""
    pose = frames[start].odometry.between(frames[end].odometry)
    way, turn = math.hypot(pose.x, pose.y), abs(pose.theta)
    return Edge(start, end, pose, _information(way, turn), robust=False)


def _information(way: float, turn: float) -> NDArray[np.float64]:
    along = 0.03 + 0.08 * way + 0.03 * turn
    theta = 0.02 + 0.08 * way + 0.10 * turn
    return np.diag([along**-2, along**-2, theta**-2])


def build_chain(
    frames: Sequence[Keyframe], progress: Callable[[float], None]
) -> tuple[list[Pose], list[Edge]]:
    """Return the keyframes' poses, the first at its odometry, and an edge between each two."""
    poses, edges = [frames[0].odometry], []
    for index in range(1, len(frames)):
        guess = poses[-1].compose(frames[index - 1].odometry.between(frames[index].odometry))
        edge = _match(frames, poses, guess)
        counted = odometry_edge(index - 1, index, frames)
        if edge is None or _agrees(counted, edge):
            edges.append(counted)
        if edge is not None:
            edges.append(edge)
            guess = poses[-1].compose(edge.pose)
        poses.append(guess)
        progress(index)
    return poses, edges


def _agrees(counted: Edge, seen: Edge) -> bool:
    """Whether the odometry may be right: no wheel missed a turn that the scans show."""
    off = abs(wrap_angle(seen.pose.theta - counted.pose.theta))
    return off * math.sqrt(counted.information[2, 2]) < _MISSED_SIGMAS


def _match(frames: Sequence[Keyframe], poses: Sequence[Pose], guess: Pose) -> Edge | None:
    """Match the keyframe after the last pose with those before; None if no match is accepted."""
    index = len(poses)
    points = frames[index].points
    if not len(points):
        return None
    last = poses[-1]
    first = max(0, index - _BEFORE)
    target = join((last.between(poses[i]), frames[i]) for i in range(first, index))
    expected = last.between(guess)
    way, turn = math.hypot(expected.x, expected.y), abs(expected.theta)
    window = min(0.2 + 0.25 * way + 0.1 * turn, _LARGEST_STEP)
    turn_window = min(0.06 + 0.15 * way + 0.2 * turn, _LARGEST_TURN)
    found = _aligned(points, target, expected, (window, turn_window))
    if found is None or found.share < _SURE_SHARE:
        # Wheels may have missed a turn: the heading is searched as far as the scans ask.
        turned = _aligned(points, target, expected, (window, _MISSED_TURN))
        if turned is not None and turned.share >= _SURE_SHARE:
            found = turned
    return None if found is None else Edge(index - 1, index, found.pose, found.information)


def _aligned(
    points: NDArray[np.float64], target: Cloud, expected: Pose, reach: tuple[float, float]
) -> Alignment | None:
    """Return the alignment of points (n, 2) with a cloud, found within a reach, m and rad."""
    peak = search(points, target.points, expected, *reach)
    start = peak.pose if peak.score > _MIN_SCORE else expected
    found = align(points, target, start)
    if found is None or found.share < _MIN_SHARE or not close(start, found.pose, _NEAR_PEAK):
        return None
    return found


def close(one: Pose, other: Pose, limits: tuple[float, float]) -> bool:
    """Whether two poses differ by no more than ``limits``, m and rad."""
    off = one.between(other)
    return math.hypot(off.x, off.y) <= limits[0] and abs(off.theta) <= limits[1]

"""Convex polygons that rays hit: parts of bodies, as a laser or a sonar meets them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from maps.pose import Pose


@dataclass(frozen=True, slots=True, eq=False)
class Silhouette:
    """A convex polygon as strips of half-planes about the middle of its bounding box.

    middle: x and y in base_link, m. normals (k, 2), outward. offsets (k,): m from the middle to
    each side. reach: m from the middle to the farthest corner.
    """

    middle: Pose
    normals: NDArray[np.float64]
    offsets: NDArray[np.float64]
    reach: float


def silhouette_of(corners: Sequence[tuple[float, float]]) -> Silhouette:
    """Return the silhouette of corners in base_link, m, counter-clockwise."""
    at = np.array(corners)
    middle = (at.min(axis=0) + at.max(axis=0)) / 2
    at -= middle
    sides = np.roll(at, -1, axis=0) - at
    normals = np.column_stack((sides[:, 1], -sides[:, 0]))
    normals /= np.hypot(normals[:, 0], normals[:, 1])[:, None]
    offsets = (normals * at).sum(axis=1)
    reach = float(np.hypot(at[:, 0], at[:, 1]).max())
    return Silhouette(Pose(float(middle[0]), float(middle[1]), 0.0), normals, offsets, reach)


class Shapes(NamedTuple):
    """The m silhouettes of many bodies, each filled up to k sides.

    owner (m,): index of the body. reach (m,). normals (m, k, 2), offsets (m, k): a side that only
    fills up has normal 0 and is never crossed.
    """

    owner: NDArray[np.intp]
    reach: NDArray[np.float64]
    normals: NDArray[np.float64]
    offsets: NDArray[np.float64]


def shapes_of(bodies: Sequence[Sequence[Silhouette]]) -> Shapes:
    """Return the silhouettes of bodies in one table."""
    parts = [(index, part) for index, own in enumerate(bodies) for part in own]
    most = max((len(part.offsets) for _, part in parts), default=0)
    normals, offsets = np.zeros((len(parts), most, 2)), np.ones((len(parts), most))
    for row, (_, part) in enumerate(parts):
        normals[row, : len(part.offsets)] = part.normals
        offsets[row, : len(part.offsets)] = part.offsets
    owner = np.array([index for index, _ in parts], dtype=np.intp)
    return Shapes(owner, np.array([part.reach for _, part in parts]), normals, offsets)


def middles_of(
    bodies: Sequence[Sequence[Silhouette]], poses: Sequence[Pose]
) -> NDArray[np.float64]:
    """Return (m, 3) places of the silhouettes' middles: x, y (m) and heading (rad), map frame."""
    rows = []
    for own, pose in zip(bodies, poses, strict=True):
        c, s = math.cos(pose.theta), math.sin(pose.theta)
        for part in own:
            x, y = part.middle.x, part.middle.y
            rows.append((pose.x + c * x - s * y, pose.y + s * x + c * y, pose.theta))
    return np.array(rows).reshape(-1, 3)

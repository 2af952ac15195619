"""Convex polygons: grown by a margin, and whether two overlap."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Corner = tuple[float, float]


def grown(corners: tuple[Corner, ...], margin: float) -> tuple[Corner, ...]:
    """Return a counter-clockwise polygon whose sides lie ``margin`` m farther out."""
    at = np.array(corners)
    normals = outward_normals(at)
    before = np.roll(normals, 1, axis=0)
    # A corner moves until it is the margin beyond both of its sides.
    both = 1.0 + (normals * before).sum(axis=1)
    moved = at + margin * (normals + before) / both[:, None]
    return tuple((x, y) for x, y in moved.tolist())


def outward_normals(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return unit normals (n, 2) of the sides from each corner (n, 2) to the next."""
    sides = np.roll(corners, -1, axis=0) - corners
    normals = np.column_stack((sides[:, 1], -sides[:, 0]))
    return np.asarray(normals / np.hypot(normals[:, 0], normals[:, 1])[:, None])


def convex_overlap(a: NDArray[np.float64], b: NDArray[np.float64]) -> bool:
    """Return whether two polygons, corners (n, 2) and (m, 2), overlap: no side separates them."""
    return not any(
        bool(((two @ normals.T).min(axis=0) >= (one * normals).sum(axis=1)).any())
        for one, two in ((a, b), (b, a))
        for normals in (outward_normals(one),)
    )

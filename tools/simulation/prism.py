"""Rendering of upright prisms for a level camera, side by side."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from maps.pose import Pose
from tools.simulation.truth.camera_truth import CameraTruth

Color = tuple[int, int, int]
"""Blue, green, red of a surface in white light."""

_NEAREST = 0.05  # m before the lens


@dataclass(frozen=True, slots=True)
class Prism:
    """An upright prism: corners (n, 2) of its base, m, map frame, counter-clockwise; from
    ``bottom`` to ``top``, m; of one colour, its sides shaded by their direction to the light."""

    corners: NDArray[np.float64]
    bottom: float
    top: float
    color: Color


def rectangle(
    x: float, y: float, theta: float, half_length: float, half_width: float
) -> NDArray[np.float64]:
    """Return the corners (4, 2) of an oriented rectangle, m and rad, counter-clockwise."""
    c, s = math.cos(theta), math.sin(theta)
    corners = np.array(((1, 1), (-1, 1), (-1, -1), (1, -1))) * (half_length, half_width)
    return np.asarray(corners @ np.array(((c, s), (-s, c))) + (x, y))


def paint(
    picture: NDArray[np.uint8],
    depth: NDArray[np.float64],
    lens: Pose,
    prism: Prism,
    camera: CameraTruth,
) -> None:
    """Paint the sides of a prism that face the lens into a picture (height, width, 3).

    lens: map_from_lens. depth: (width,) m, distance ahead in each column beyond which a wall hides.
    """
    c, s = math.cos(lens.theta), math.sin(lens.theta)
    corners = (prism.corners - (lens.x, lens.y)) @ np.array(((c, -s), (s, c)))
    following = np.roll(corners, -1, axis=0)
    for (ax, ay), (bx, by) in zip(corners.tolist(), following.tolist(), strict=True):
        if ax * by - ay * bx >= 0.0:
            continue  # a back side
        side = _clipped(ax, ay, bx, by)
        if side is not None:
            normal = lens.theta + math.atan2(ax - bx, by - ay)
            shade = 0.8 + 0.2 * math.sin(normal + 0.7)
            _paint_side(picture, depth, side, prism, shade, camera)


def _paint_side(
    picture: NDArray[np.uint8],
    depth: NDArray[np.float64],
    side: tuple[float, float, float, float],
    prism: Prism,
    shade: float,
    camera: CameraTruth,
) -> None:
    ax, ay, bx, by = side
    middle_x, middle_y = (camera.width - 1) / 2, (camera.height - 1) / 2
    scale_a, scale_b = camera.focal_length / ax, camera.focal_length / bx
    left, right = middle_x - ay * scale_a, middle_x - by * scale_b
    first, last = max(math.floor(min(left, right)), 0), math.ceil(max(left, right)) + 1
    if last <= 0 or first >= camera.width:
        return
    low, high = camera.mount_height - prism.bottom, camera.mount_height - prism.top
    polygon = np.array(
        (
            (left, middle_y + low * scale_a),
            (right, middle_y + low * scale_b),
            (right, middle_y + high * scale_b),
            (left, middle_y + high * scale_a),
        )
    )
    hidden = np.flatnonzero(depth[first:last] < min(ax, bx) - 0.1) + first
    kept = picture[:, hidden] if hidden.size else None
    cv2.fillConvexPoly(
        picture,
        np.rint(polygon * 16.0).astype(np.int32),
        tuple(shade * channel for channel in prism.color),
        lineType=cv2.LINE_8,
        shift=4,
    )
    if kept is not None:
        picture[:, hidden] = kept


def _clipped(
    ax: float, ay: float, bx: float, by: float
) -> tuple[float, float, float, float] | None:
    """Return the part of a side before the lens (x ahead, y left, m); None if there is none."""
    if max(ax, bx) <= _NEAREST:
        return None
    if ax < _NEAREST:
        share = (_NEAREST - ax) / (bx - ax)
        ax, ay = _NEAREST, ay + share * (by - ay)
    elif bx < _NEAREST:
        share = (_NEAREST - bx) / (ax - bx)
        bx, by = _NEAREST, by + share * (ay - by)
    return ax, ay, bx, by

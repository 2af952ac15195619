"""Ray casting in the simulated world: exact on the grid's cells and on robots' outlines."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from maps.occupancy_map import OCCUPIED, OccupancyMap

_BIAS = 1e-6  # cells; a ray this near to a side ahead of it is in the next cell already
_OUTSIDE = 0.25  # stands for "left the map" among the free squares' half sizes


class RayCaster:
    """Casts rays against the occupied cells of a map; unknown cells and the outside are empty.

    Around each free cell a square of known size is empty (chessboard distance to the nearest
    occupied cell), so a ray may be carried to the side of that square at once. Near walls the
    square is the cell itself: what is found is the exact side of the occupied cell.
    """

    def __init__(self, occupancy: OccupancyMap) -> None:
        occupied = occupancy.cells == OCCUPIED
        if occupied.any():
            chessboard = cv2.distanceTransform(
                np.where(occupied, 0, 255).astype(np.uint8), cv2.DIST_C, 3
            )
        else:
            chessboard = np.full(occupied.shape, float(max(occupied.shape)), dtype=np.float32)
        # Half sizes of the empty squares in cells: 0.5 beside a wall, -0.5 inside it; one more
        # row and column all round for what left the map.
        half = np.pad(chessboard.astype(np.float64) - 0.5, 1, constant_values=_OUTSIDE)
        self._width = half.shape[1]
        self._half = half.ravel()
        self._limits = (half.shape[0] - 1.0, half.shape[1] - 1.0)
        self._resolution = occupancy.resolution
        self._origin = (
            occupancy.origin.x - occupancy.resolution,
            occupancy.origin.y - occupancy.resolution,
        )

    def cast(
        self, x: ArrayLike, y: ArrayLike, angles: NDArray[np.float64], max_range: float
    ) -> NDArray[np.float64]:
        """Return (n,) ranges, m, to the first occupied cell; inf beyond max_range.

        x, y: origins in m, map frame, scalars or (n,). angles: (n,) rad, map frame. A ray that
        starts in an occupied cell has range 0, one that starts outside the map inf.
        """
        n = len(angles)
        ranges = np.full(n, np.inf)
        rays = np.arange(n)
        # Everything in cells from here on.
        px = np.broadcast_to((np.asarray(x) - self._origin[0]) / self._resolution, (n,))
        py = np.broadcast_to((np.asarray(y) - self._origin[1]) / self._resolution, (n,))
        dx, dy = np.cos(angles), np.sin(angles)
        with np.errstate(divide="ignore"):
            inverse_x, inverse_y = 1.0 / np.abs(dx), 1.0 / np.abs(dy)
        sign_x, sign_y = np.sign(dx), np.sign(dy)
        bias_x, bias_y = _BIAS * sign_x, _BIAS * sign_y
        travelled = np.zeros(n)
        reach = max_range / self._resolution
        top, right = self._limits
        while len(rays):
            qx, qy = px + dx * travelled, py + dy * travelled
            col = np.floor(np.minimum(np.maximum(qx + bias_x, 0.0), right))
            row = np.floor(np.minimum(np.maximum(qy + bias_y, 0.0), top))
            half = self._half[(row * self._width + col).astype(np.intp)]
            hit = half < 0.0
            if hit.any():
                ranges[rays[hit]] = travelled[hit] * self._resolution
            # To the side of the square that the ray leaves through.
            exit_x = (half - sign_x * (qx - col - 0.5)) * inverse_x
            exit_y = (half - sign_y * (qy - row - 0.5)) * inverse_y
            travelled = travelled + np.minimum(exit_x, exit_y)
            going = (half > _OUTSIDE) & (travelled <= reach)
            if not going.all():
                rays, px, py, dx, dy = rays[going], px[going], py[going], dx[going], dy[going]
                inverse_x, inverse_y = inverse_x[going], inverse_y[going]
                sign_x, sign_y, travelled = sign_x[going], sign_y[going], travelled[going]
                bias_x, bias_y = bias_x[going], bias_y[going]
        return ranges


def cast_bodies(
    x: ArrayLike,
    y: ArrayLike,
    angles: NDArray[np.float64],
    rectangles: NDArray[np.float64],
    max_range: float,
) -> NDArray[np.float64]:
    """Return (n,) ranges, m, to the nearest of oriented rectangles; inf beyond max_range.

    x, y: origins in m, map frame, scalars or (n,). angles: (n,) rad, map frame. rectangles: (m, 5)
    rows (centre x, centre y, theta, half length, half width). From inside one the range is 0.
    """
    ranges = np.full(len(angles), np.inf)
    for centre_x, centre_y, theta, half_length, half_width in rectangles:
        c, s = np.cos(theta), np.sin(theta)
        from_x, from_y = np.asarray(x) - centre_x, np.asarray(y) - centre_y
        px, py = c * from_x + s * from_y, c * from_y - s * from_x
        dx, dy = np.cos(angles - theta), np.sin(angles - theta)
        near_x, far_x = _slab(px, dx, half_length)
        near_y, far_y = _slab(py, dy, half_width)
        enter, leave = np.maximum(near_x, near_y), np.minimum(far_x, far_y)
        met = (enter <= leave) & (leave >= 0.0)
        ranges = np.minimum(ranges, np.where(met, np.maximum(enter, 0.0), np.inf))
    ranges[ranges > max_range] = np.inf
    return ranges


def _slab(
    position: NDArray[np.float64], direction: NDArray[np.float64], half: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return where rays enter and leave the strip |position| <= half."""
    # A ray along the strip would divide zero by zero; a tiny slope has the same effect.
    safe = np.where(np.abs(direction) < 1e-12, 1e-12, direction)
    a, b = (-half - position) / safe, (half - position) / safe
    return np.minimum(a, b), np.maximum(a, b)

"""Ray casting in the simulated world: exact on the grid's cells and on robots' outlines."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from maps.occupancy_map import OCCUPIED, OccupancyMap

_BIAS = 1e-6  # cells; a ray this near to a side ahead of it is in the next cell already
_NEVER = 1e12  # cells
_WALL, _OUTSIDE = 0, -1  # stand for no block at all among the blocks' widths

_Steps = NDArray[np.int16]


class RayCaster:
    """Casts rays against the occupied cells of a map; unknown cells and the outside are empty.

    From each free cell a rectangular block of cells is known to be empty, one for each of the
    four ways a ray may run (left or right, down or up), so a ray is carried to the side of that
    block at once. What is found is the exact side of the occupied cell.
    """

    def __init__(self, occupancy: OccupancyMap) -> None:
        walls = occupancy.cells == OCCUPIED
        self._widths, self._heights = _block_tables(walls.tobytes(), walls.shape)
        # One more row and column all round, for what left the map.
        rows, self._columns = walls.shape[0] + 2, walls.shape[1] + 2
        self._cells = rows * self._columns
        self._limits = (rows - 1.0, self._columns - 1.0)
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
        left, down = dx < 0.0, dy < 0.0
        blocks = (left + 2 * down) * self._cells
        with np.errstate(divide="ignore"):
            inverse_x, inverse_y = 1.0 / np.abs(dx), 1.0 / np.abs(dy)
            # A ray along an axis never leaves by the other side; infinity times 0 would be none.
            inverse_x, inverse_y = np.minimum(inverse_x, _NEVER), np.minimum(inverse_y, _NEVER)
        sign_x, sign_y = np.where(left, -1.0, 1.0), np.where(down, -1.0, 1.0)
        bias_x, bias_y = _BIAS * np.sign(dx), _BIAS * np.sign(dy)
        travelled = np.zeros(n)
        reach = max_range / self._resolution
        top, right = self._limits
        while len(rays):
            qx, qy = px + dx * travelled, py + dy * travelled
            col = np.floor(np.minimum(np.maximum(qx + bias_x, 0.0), right))
            row = np.floor(np.minimum(np.maximum(qy + bias_y, 0.0), top))
            block = blocks + (row * self._columns + col).astype(np.intp)
            width = self._widths[block]
            hit = width == _WALL
            if hit.any():
                ranges[rays[hit]] = travelled[hit] * self._resolution
            # To the side of the block that the ray leaves through: the cell's own middle is half
            # a cell from its near sides.
            exit_x = (width - 0.5 - sign_x * (qx - col - 0.5)) * inverse_x
            exit_y = (self._heights[block] - 0.5 - sign_y * (qy - row - 0.5)) * inverse_y
            travelled = travelled + np.minimum(exit_x, exit_y)
            going = (width > _WALL) & (travelled <= reach)
            if not going.all():
                rays, px, py, dx, dy = rays[going], px[going], py[going], dx[going], dy[going]
                inverse_x, inverse_y = inverse_x[going], inverse_y[going]
                sign_x, sign_y, travelled = sign_x[going], sign_y[going], travelled[going]
                bias_x, bias_y, blocks = bias_x[going], bias_y[going], blocks[going]
        return ranges


@lru_cache(maxsize=4)
def _block_tables(walls: bytes, shape: tuple[int, int]) -> tuple[_Steps, _Steps]:
    """Return widths and heights (4 * cells,) of the blocks: right and up, left and up, then down.

    walls: (rows, cols) bool of the map, as bytes. Kept, for a study makes many worlds of one map.
    """
    solid = np.pad(np.frombuffer(walls, dtype=bool).reshape(shape), 1, constant_values=True)
    inner = np.zeros_like(solid)
    inner[1:-1, 1:-1] = True
    widths, heights = [], []
    for step_y in (1, -1):
        for step_x in (1, -1):
            width, height = _empty_blocks(solid, step_x, step_y)
            widths.append(np.where(inner, width, _OUTSIDE).ravel())
            heights.append(height.ravel())
    return np.concatenate(widths).astype(np.int16), np.concatenate(heights)


def _empty_blocks(solid: NDArray[np.bool_], step_x: int, step_y: int) -> tuple[_Steps, _Steps]:
    """Return (rows, cols) widths and heights, cells, of an empty block that starts in each cell.

    The block runs in the directions step_x and step_y (+1 or -1): the largest square, then drawn
    out along whichever side goes farther. 0 by 0 in a solid cell. The rim must be solid.
    """
    turned = solid[::step_y, ::step_x]
    rows, cols = turned.shape
    # count[r, c]: solid cells below row r and left of column c.
    count = np.zeros((rows + 1, cols + 1), dtype=np.int32)
    np.cumsum(np.cumsum(turned, axis=0, dtype=np.int32), axis=1, out=count[1:, 1:])
    flat = count.ravel()
    row, col = np.arange(rows, dtype=np.int32)[:, None], np.arange(cols, dtype=np.int32)
    below = row * (cols + 1)
    near_corner = flat[below + col]

    def is_empty(width: NDArray[np.int32], height: NDArray[np.int32]) -> NDArray[np.bool_]:
        # A block cut off at the edge holds a part of the solid rim, and is not empty either.
        above = np.minimum(row + height, rows) * (cols + 1)
        beside = np.minimum(col + width, cols)
        return np.asarray(
            flat[above + beside] - flat[above + col] - flat[below + beside] + near_corner == 0
        )

    jumps = [1 << power for power in reversed(range(max(rows, cols).bit_length()))]
    side: NDArray[np.int32] = np.zeros(turned.shape, dtype=np.int32)
    for jump in jumps:
        side += jump * is_empty(side + jump, side + jump)
    wide, high = side.copy(), side.copy()
    for jump in jumps:
        wide += jump * is_empty(wide + jump, side)
        high += jump * is_empty(side, high + jump)
    free, flatter = side > 0, wide >= high
    width = np.where(free, np.where(flatter, wide, side), 0)
    height = np.where(free, np.where(flatter, side, high), 0)
    return (
        np.ascontiguousarray(width[::step_y, ::step_x], dtype=np.int16),
        np.ascontiguousarray(height[::step_y, ::step_x], dtype=np.int16),
    )


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

"""Ray casting in the simulated world, exact on the grid's cells and on bodies' silhouettes."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from maps.occupancy_map import OCCUPIED, OccupancyMap
from tools.simulation.silhouette import Shapes

_BIAS = 1e-6  # cells; a ray this near to a side ahead of it counts as in the next cell
_NEVER = 1e12  # cells
_NEAR = 1e-6  # m; margin about a polygon's circumcircle
_WALL, _OUTSIDE = 0, -1  # in the table of block widths: no block

_Steps = NDArray[np.int16]


class RayCaster:
    """Casts rays against the occupied cells of a map; unknown cells and the outside are empty.

    For each free cell and each of the four directions of rays (left or right, down or up) a
    rectangular block of empty cells is tabulated, so a ray moves to the side of that block in one
    step. The range is to the exact side of the occupied cell.
    """

    def __init__(self, occupancy: OccupancyMap) -> None:
        walls = occupancy.cells == OCCUPIED
        self._sizes = _block_table(walls.tobytes(), walls.shape)
        # One more row and column all round, for rays that have left the map.
        rows, self._columns = walls.shape[0] + 2, walls.shape[1] + 2
        self._cells = rows * self._columns
        self._limits = np.array(((self._columns - 1.0,), (rows - 1.0,)))
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
        # In cells from here on; row 0 is x and row 1 is y, so one call computes both.
        state = np.empty((11, n))
        position, direction, inverse, sign, bias = (state[i : i + 2] for i in range(0, 10, 2))
        position[0] = (np.asarray(x) - self._origin[0]) / self._resolution
        position[1] = (np.asarray(y) - self._origin[1]) / self._resolution
        np.cos(angles, out=direction[0])
        np.sin(angles, out=direction[1])
        back = direction < 0.0
        np.add(back[0], 2 * back[1], out=state[10])
        state[10] *= self._cells  # where the table of blocks for this direction begins
        with np.errstate(divide="ignore"):
            # A ray along an axis never leaves by the other side; infinity times 0 would be nan.
            np.minimum(1.0 / np.abs(direction), _NEVER, out=inverse)
        sign[:] = 1.0 - 2.0 * back
        np.multiply(_BIAS, np.sign(direction), out=bias)
        travelled = np.zeros(n)
        reach = max_range / self._resolution
        while len(rays):
            at = direction * travelled
            at += position
            cell = at + bias
            np.maximum(cell, 0.0, out=cell)
            np.minimum(cell, self._limits, out=cell)
            np.floor(cell, out=cell)
            block = cell[1] * self._columns
            block += cell[0]
            block += state[10]
            size = self._sizes.take(block.astype(np.intp), axis=0).T
            width = size[0]
            # To the side by which the ray leaves the block: the cell's own middle is half
            # a cell from its near sides.
            at -= cell
            at -= 0.5
            at *= sign
            way = size - 0.5
            way -= at
            way *= inverse
            onward = travelled + np.minimum(way[0], way[1])
            going = width > _WALL
            going &= onward <= reach
            left = np.flatnonzero(going)
            if len(left) < len(rays):
                hit = width == _WALL
                ranges[rays[hit]] = travelled[hit] * self._resolution
                rays, travelled, state = rays[left], onward[left], state.take(left, axis=1)
                position, direction, inverse, sign, bias = (
                    state[i : i + 2] for i in range(0, 10, 2)
                )
            else:
                travelled = onward
        return ranges


@lru_cache(maxsize=4)
def _block_table(walls: bytes, shape: tuple[int, int]) -> _Steps:
    """Return widths and heights (4 * cells, 2) of the blocks: right and up, left and up, then down.

    walls: (rows, cols) bool of the map, as bytes. Cached: a study makes many worlds of one map.
    """
    solid = np.pad(np.frombuffer(walls, dtype=bool).reshape(shape), 1, constant_values=True)
    inner = np.zeros_like(solid)
    inner[1:-1, 1:-1] = True
    blocks = []
    for step_y in (1, -1):
        for step_x in (1, -1):
            width, height = _empty_blocks(solid, step_x, step_y)
            width = np.where(inner, width, _OUTSIDE).astype(np.int16)
            blocks.append(np.stack((width.ravel(), height.ravel()), axis=1))
    return np.concatenate(blocks)


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
    middles: NDArray[np.float64],
    shapes: Shapes,
    max_range: float,
    own: NDArray[np.intp] | None = None,
) -> NDArray[np.float64]:
    """Return (n,) ranges, m, to the nearest of convex polygons; inf beyond max_range.

    x, y: origins in m, map frame, scalars or (n,). angles: (n,) rad, map frame. middles: (m, 3)
    places x, y, theta of the shapes. From inside one the range is 0. own (n,): the body that each
    ray starts from, which it does not hit.
    """
    ranges = np.full(len(angles), np.inf)
    if not len(middles):
        return ranges
    # 1. Select the few rays that pass near a polygon.
    from_x = np.asarray(x) - middles[:, 0, None]
    from_y = np.asarray(y) - middles[:, 1, None]
    dx, dy = np.cos(angles), np.sin(angles)
    reach = shapes.reach[:, None] + _NEAR
    near = np.abs(from_x * dy - from_y * dx) < reach
    near &= from_x * dx + from_y * dy < reach
    if own is not None:
        near &= shapes.owner[:, None] != own
    which, ray = near.nonzero()
    if not len(ray):
        return ranges
    # 2. Clip these by each side's half-plane, in the polygon's own frame.
    theta = middles[which, 2]
    c, s = np.cos(theta), np.sin(theta)
    from_x = np.broadcast_to(from_x, near.shape)[which, ray]
    from_y = np.broadcast_to(from_y, near.shape)[which, ray]
    px, py = c * from_x + s * from_y, c * from_y - s * from_x
    turned = angles[ray] - theta
    normal_x, normal_y = shapes.normals[which].transpose(2, 1, 0)
    slope = normal_x * np.cos(turned) + normal_y * np.sin(turned)
    gap = shapes.offsets[which].T - (normal_x * px + normal_y * py)
    # A ray along a side would divide zero by zero; a tiny slope has the same effect.
    slope[np.abs(slope) < 1e-12] = 1e-12
    at = gap / slope
    enters = slope < 0.0
    enter = np.where(enters, at, -np.inf).max(axis=0)
    leave = np.where(enters, np.inf, at).min(axis=0)
    met = (enter <= leave) & (leave >= 0.0)
    np.minimum.at(ranges, ray[met], np.maximum(enter[met], 0.0))
    ranges[ranges > max_range] = np.inf
    return ranges

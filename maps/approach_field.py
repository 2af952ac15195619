"""The way to the border round walls: geodesic distance in the space free for a robot."""

from __future__ import annotations

import math
from typing import NamedTuple, TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from maps.border import Border
from maps.occupancy_map import FREE, OccupancyMap

_ROOM = 0.40  # m from the walls: the base's corners reach 0.37 m round the axle, and a margin
_NARROW_ROOM = 0.30  # m from the walls: enough to drive straight, not to turn on the spot
_NARROW_COST = 3.0  # a metre of narrow way counts as so many, so it is taken for want of another
_SIGHT_ROOM = 0.30  # m from the walls that a line of sight keeps, as far as its start does
_BESIDE = 0.30  # m; nearer to the border no wall fits between, for it keeps 0.45 m from all
_LOOK_AHEAD = 0.8  # m along the way to the point steered for
_SNAP = 0.6  # m to the nearest cell with a way, for a robot that stands outside all of them
_MOVES = np.array(  # (rows, cols) between neighboring cells; 16 directions keep lengths within 3 %
    [(0, 1), (1, 0), (1, 1), (1, -1), (1, 2), (2, 1), (2, -1), (1, -2)]
)
_NOWHERE = -1

_Number = TypeVar("_Number", bound=np.generic)


class Approach(NamedTuple):
    """The way to the border from one place, where a wall hides it.

    distance: m along the way, infinite if there is none; direction: unit vector in the map frame
    along its beginning, (0, 0) if there is none.
    """

    distance: float
    direction: tuple[float, float]


_NO_WAY = Approach(math.inf, (0.0, 0.0))


class ApproachField:
    """The ways to a border from everywhere on a map; immutable once built."""

    def __init__(self, occupancy: OccupancyMap, border: Border) -> None:
        """Find all shortest ways (Dijkstra from every point of the border at once)."""
        self._occupancy = occupancy
        self._padded = np.pad(_room_around(occupancy), 1)  # there is no room outside the map
        self._clearance = self._padded[1:-1, 1:-1]
        self._corner = np.array(((occupancy.origin.x,), (occupancy.origin.y,)))
        self._last_cell = np.array(self._padded.shape[::-1])[:, None] - 1.0
        rows, cols = occupancy.cells_at(border.polyline(occupancy.resolution / 2))
        inside = occupancy.inside(rows, cols)
        goals = np.zeros(occupancy.cells.shape, dtype=np.bool_)
        goals[rows[inside], cols[inside]] = True
        cost, onward = _shortest_ways(self._clearance, goals)
        self._distance = cost * occupancy.resolution
        self._onward = onward
        self._nearest = _nearest_with_way(np.isfinite(cost))

    def around_walls(self, x: float, y: float, foot: tuple[float, float]) -> Approach | None:
        """Return the way from (x, y) if a wall hides foot, the closest border point; else None.

        All in m in the map frame. None means that the straight line is the way.
        """
        if math.dist((x, y), foot) < _BESIDE or self._sees(x, y, *foot):
            return None
        cell = self._cell_with_way(x, y)
        if cell == _NOWHERE:
            return _NO_WAY
        aim = self._point_ahead(x, y, cell)
        dx, dy = aim[0] - x, aim[1] - y
        length = math.hypot(dx, dy)
        if length == 0.0:
            return None  # on the border's own cell
        beside = math.dist((x, y), self._center(cell))
        distance = float(self._distance.flat[cell]) + beside
        return Approach(distance, (dx / length, dy / length))

    def _cell_with_way(self, x: float, y: float) -> int:
        """Index of the cell at a place, or of one near by and in sight, that has a way."""
        rows, cols = self._occupancy.cells_at((x, y))
        if not self._occupancy.inside(rows, cols)[0]:
            return _NOWHERE
        here = int(rows[0]) * self._clearance.shape[1] + int(cols[0])
        cell = int(self._nearest.flat[here])
        if cell in (here, _NOWHERE):
            return cell
        center = self._center(cell)
        near = math.dist((x, y), center) <= _SNAP
        return cell if near and self._sees(x, y, *center) else _NOWHERE

    def _point_ahead(self, x: float, y: float, cell: int) -> tuple[float, float]:
        """Farthest point of the way, within reach, that can be driven to in a straight line."""
        points = [self._center(cell)]
        while math.dist(points[-1], (x, y)) < _LOOK_AHEAD:
            cell = int(self._onward.flat[cell])
            if cell == _NOWHERE:
                break
            points.append(self._center(cell))
        for point in points[:1:-2]:
            if self._keeps_room(x, y, *point):
                return point
        return points[min(1, len(points) - 1)]

    def _center(self, cell: int) -> tuple[float, float]:
        row, col = divmod(cell, self._clearance.shape[1])
        resolution, origin = self._occupancy.resolution, self._occupancy.origin
        return origin.x + (col + 0.5) * resolution, origin.y + (row + 0.5) * resolution

    def _keeps_room(self, x: float, y: float, to_x: float, to_y: float) -> bool:
        """Tell whether a straight line stays as far from the walls as its start, or far enough."""
        room = self._room_along(x, y, to_x, to_y)
        return bool(room.min() >= min(_ROOM, room[0]))

    def _sees(self, x: float, y: float, to_x: float, to_y: float) -> bool:
        """Tell whether a straight line keeps its room from the walls, as far as its start does."""
        resolution = self._occupancy.resolution
        room = self._room_along(x, y, to_x, to_y)
        needed = min(_SIGHT_ROOM, max(float(room[0]) - resolution, resolution / 2))
        return bool(room.min() >= needed)

    def _room_along(self, x: float, y: float, to_x: float, to_y: float) -> NDArray[np.float32]:
        """Room from the walls along a straight line, from its start on; 0 outside the map."""
        resolution = self._occupancy.resolution
        count = math.ceil(2.0 * math.hypot(to_x - x, to_y - y) / resolution) + 2
        start, end = np.array(((x,), (y,))), np.array(((to_x,), (to_y,)))
        line = np.arange(count) * ((end - start) / (count - 1)) + start
        line[:, -1:] = end
        cells = np.floor((line - self._corner) / resolution) + 1.0  # of the padded map
        col, row = np.minimum(np.maximum(cells, 0.0), self._last_cell).astype(np.intp)
        return np.asarray(self._padded.take(row * self._padded.shape[1] + col))


def _room_around(occupancy: OccupancyMap) -> NDArray[np.float32]:
    """Distance (rows, cols), m, from each free cell's centre to the nearest wall; else 0.

    What is not known to be free has no room, and the map's edge is a wall.
    """
    room = occupancy.distance_field() - occupancy.resolution / 2
    rows, cols = room.shape
    row, col = np.arange(rows)[:, None], np.arange(cols)[None, :]
    rim = np.minimum(np.minimum(row, rows - 1 - row), np.minimum(col, cols - 1 - col)) + 0.5
    room = np.minimum(room, rim * occupancy.resolution)
    return np.where(occupancy.cells == FREE, np.maximum(room, 0.0), 0.0).astype(np.float32)


def _shortest_ways(
    clearance: NDArray[np.float32], goals: NDArray[np.bool_]
) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """Return (rows, cols) lengths in cells to the nearest goal, and the next cell on the way.

    Length infinite and next cell -1 where there is no way; next cell -1 at the goals.
    """
    node = np.full(clearance.shape, _NOWHERE, dtype=np.int32)
    cells = np.flatnonzero((clearance >= _NARROW_ROOM) | (goals & (clearance > 0.0)))
    node.flat[cells] = np.arange(len(cells))
    cost = np.full(clearance.shape, np.inf, dtype=np.float32)
    onward = np.full(clearance.shape, _NOWHERE, dtype=np.int32)
    starts = node[goals & (node != _NOWHERE)]
    if not len(starts):
        return cost, onward
    lengths, before, _ = dijkstra(
        _graph(node, clearance, len(cells)),
        indices=starts,
        min_only=True,
        return_predecessors=True,
    )
    cost.flat[cells] = lengths
    known = before >= 0
    onward.flat[cells[known]] = cells[before[known]]
    return cost, onward


def _graph(
    node: NDArray[np.int32], clearance: NDArray[np.float32], count: int
) -> csr_array[np.float64]:
    """Graph (nodes, nodes) of the lengths between neighboring cells."""
    factor = np.where(clearance < _ROOM, _NARROW_COST, 1.0)
    ones, others, lengths = [], [], []
    for move in _MOVES:
        for row, col in (move, -move):
            here, there = _shifted(node, row, col)
            joined = (here != _NOWHERE) & (there != _NOWHERE)
            cost, other_cost = (side[joined] for side in _shifted(factor, row, col))
            ones.append(here[joined])
            others.append(there[joined])
            lengths.append((cost + other_cost) / 2.0 * math.hypot(row, col))
    edges = (np.concatenate(lengths), (np.concatenate(ones), np.concatenate(others)))
    return csr_array(edges, shape=(count, count))


def _shifted(
    grid: NDArray[_Number], rows: int, cols: int
) -> tuple[NDArray[_Number], NDArray[_Number]]:
    """Two views of a grid: each cell of the first lies (rows, cols) before that of the second."""

    def parts(shift: int, size: int) -> tuple[slice, slice]:
        return slice(max(-shift, 0), size - max(shift, 0)), slice(
            max(shift, 0), size + min(shift, 0)
        )

    here_rows, there_rows = parts(rows, grid.shape[0])
    here_cols, there_cols = parts(cols, grid.shape[1])
    return grid[here_rows, here_cols], grid[there_rows, there_cols]


def _nearest_with_way(has_way: NDArray[np.bool_]) -> NDArray[np.int32]:
    """Index (rows, cols) of the nearest cell that has a way, -1 if none has."""
    if not has_way.any():
        return np.full(has_way.shape, _NOWHERE, dtype=np.int32)
    _, labels = cv2.distanceTransformWithLabels(
        np.where(has_way, 0, 255).astype(np.uint8),
        cv2.DIST_L2,
        cv2.DIST_MASK_5,
        labelType=cv2.DIST_LABEL_PIXEL,
    )
    cell_of_label = np.zeros(int(labels.max()) + 1, dtype=np.int32)
    cells = np.flatnonzero(has_way)
    cell_of_label[labels.flat[cells]] = cells
    return np.asarray(cell_of_label[labels], dtype=np.int32)

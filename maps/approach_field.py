"""Shortest paths to the border round walls: geodesic distance in the robot's free space."""

from __future__ import annotations

import math
from functools import cached_property
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from maps.border import Border
from maps.occupancy_map import FREE, OccupancyMap
from maps.shortest_paths import NOWHERE, shortest_paths

_TURNING_MARGIN_CM = 3  # beyond the reach of a body that turns on the spot
_PASSING_MARGIN_CM = 8  # beside a body that drives straight
_NARROW_COST = 3.0  # cost factor of the narrowest cells, so that wider paths are preferred
BESIDE = 0.30  # m; nearer to the border no wall can be between: it keeps 0.45 m from all walls
_LOOK_AHEAD = 0.8  # m along the path to the point steered for
_LEAST_AHEAD = 0.2  # m likewise, where a straight line has little room
_CELL_SLACK = 1.5  # cells: half a diagonal each, of a point's cell and of the nearest tight one
_SNAP = 0.6  # m to the nearest cell with a path, for a robot outside all of them


class Approach(NamedTuple):
    """The shortest path to the border from a position whose line of sight is blocked by a wall.

    distance: m along the path, infinite if there is none. direction: unit vector in the map frame
    at its start, (0, 0) if there is none.
    """

    distance: float
    direction: tuple[float, float]


_NO_PATH = Approach(math.inf, (0.0, 0.0))


class BodySize(NamedTuple):
    """Extent of a robot for path planning, m from the middle of its axle.

    reach: of its farthest corner. half_width: to each side.
    """

    reach: float
    half_width: float

    @property
    def turning_clearance(self) -> float:
        """Clearance, m, in which it turns on the spot and drives out; whole centimetres."""
        turning = (math.ceil(100.0 * self.reach) + _TURNING_MARGIN_CM) / 100.0
        return max(turning, self.passing_clearance)  # a round body turns where it cannot drive

    @property
    def passing_clearance(self) -> float:
        """Clearance, m, in which it drives straight, but cannot turn; whole centimetres."""
        return (math.ceil(100.0 * self.half_width) + _PASSING_MARGIN_CM) / 100.0


TWO_WHEELED_PIONEER = BodySize(0.3685, 0.2125)


class ApproachField:
    """The shortest paths to a border from every cell of a map; immutable once built."""

    def __init__(
        self, occupancy: OccupancyMap, border: Border, body: BodySize = TWO_WHEELED_PIONEER
    ) -> None:
        """Compute all shortest paths (Dijkstra from all points of the border at once)."""
        self._body = body
        self._occupancy = occupancy
        self._padded = np.pad(_clearances(occupancy), 1)  # no clearance outside the map
        self._clearance = self._padded[1:-1, 1:-1]
        self._corner = np.array(((occupancy.origin.x,), (occupancy.origin.y,)))
        self._last_cell = np.array(self._padded.shape[::-1])[:, None] - 1.0
        rows, cols = occupancy.cells_at(border.polyline(occupancy.resolution / 2))
        inside = occupancy.inside(rows, cols)
        goals = np.zeros(occupancy.cells.shape, dtype=np.bool_)
        goals[rows[inside], cols[inside]] = True
        cost, next_cell = shortest_paths(_cell_costs(self._clearance, goals, body), goals)
        self._distance = cost * occupancy.resolution
        self._next_cell = next_cell
        self._nearest = _nearest_with_path(np.isfinite(cost))

    def around_walls(self, x: float, y: float, foot: tuple[float, float]) -> Approach | None:
        """Return the path from (x, y); None if a straight line to ``foot`` keeps its clearance.

        foot: the border's point nearest to (x, y). All in m in the map frame.
        """
        if math.dist((x, y), foot) < BESIDE or self._is_passable(x, y, *foot):
            return None
        cell = self._cell_with_path(x, y)
        if cell == NOWHERE:
            return _NO_PATH
        aim = self._point_ahead(x, y, cell)
        dx, dy = aim[0] - x, aim[1] - y
        length = math.hypot(dx, dy)
        if length == 0.0:
            return None  # on the border's own cell
        beside = math.dist((x, y), self._center(cell))
        distance = float(self._distance.flat[cell]) + beside
        return Approach(distance, (dx / length, dy / length))

    def _cell_with_path(self, x: float, y: float) -> int:
        """Return the index of a cell with a path: at (x, y), or near and in line of sight.

        NOWHERE if there is none.
        """
        rows, cols = self._occupancy.cells_at((x, y))
        if not self._occupancy.inside(rows, cols)[0]:
            return NOWHERE
        here = int(rows[0]) * self._clearance.shape[1] + int(cols[0])
        cell = int(self._nearest.flat[here])
        if cell in (here, NOWHERE):
            return cell
        center = self._center(cell)
        near = math.dist((x, y), center) <= _SNAP
        return cell if near and self._line_of_sight(x, y, *center) else NOWHERE

    def _point_ahead(self, x: float, y: float, cell: int) -> tuple[float, float]:
        """Return the farthest point of the path within _LOOK_AHEAD that a straight line reaches.

        Where none is reached with room to turn, as beside the middle of a door, that of the
        roomiest line; not the next cell, which lies at a multiple of 45 degrees: so turned a long
        body sticks in the door.
        """
        points = [self._center(cell)]
        while math.dist(points[-1], (x, y)) < _LOOK_AHEAD:
            cell = int(self._next_cell.flat[cell])
            if cell == NOWHERE:
                break
            points.append(self._center(cell))
        for point in points[:1:-2]:
            if self._is_passable(x, y, *point):
                return point
        ahead = [point for point in points if math.dist(point, (x, y)) > _LEAST_AHEAD]
        return max(ahead or points[-1:], key=lambda point: self._room(x, y, *point))

    def _center(self, cell: int) -> tuple[float, float]:
        row, col = divmod(cell, self._clearance.shape[1])
        return self._occupancy.centre(row, col)

    def _room(self, x: float, y: float, to_x: float, to_y: float) -> float:
        """Return the least clearance along a line, m."""
        return float(self._clearance_along(x, y, to_x, to_y).min())

    def _is_passable(self, x: float, y: float, to_x: float, to_y: float) -> bool:
        """Whether a line keeps the clearance to turn, or that of its start or end if less.

        A line that only a body with no error of pose could follow leads into a door's frame.
        """
        room = self._clearance_along(x, y, to_x, to_y)
        needed = min(self._body.turning_clearance, float(room[0]), float(room[-1]))
        return bool(room.min() >= max(needed, self._occupancy.resolution / 2))

    def are_passable(
        self,
        x: NDArray[np.float64],
        y: NDArray[np.float64],
        to_x: NDArray[np.float64],
        to_y: NDArray[np.float64],
    ) -> NDArray[np.bool_]:
        """Return (n,) whether each of many lines, m, is surely passable for ``around_walls``.

        Found by the clearance round the points that divide it into quarters: False where only the
        whole line would tell.
        """
        resolution = self._occupancy.resolution
        eighth = np.hypot(to_x - x, to_y - y) / 8.0 / resolution + _CELL_SLACK
        passable = np.ones(len(x), dtype=np.bool_)
        for share in (0.125, 0.375, 0.625, 0.875):
            points = np.array((x + share * (to_x - x), y + share * (to_y - y)))
            cells = np.floor((points - self._corner) / resolution) + 1.0
            col, row = np.minimum(np.maximum(cells, 0.0), self._last_cell).astype(np.intp)
            passable &= self._roominess.take(row * self._padded.shape[1] + col) > eighth
        return passable

    @cached_property
    def _roominess(self) -> NDArray[np.float32]:
        """Cells from each cell of the padded map to the nearest one too tight to turn in."""
        roomy = (self._padded >= self._body.turning_clearance).astype(np.uint8)
        return np.asarray(cv2.distanceTransform(roomy, cv2.DIST_L2, cv2.DIST_MASK_PRECISE))

    def _line_of_sight(self, x: float, y: float, to_x: float, to_y: float) -> bool:
        """Whether a line keeps the clearance to pass, or the clearance of its start if less."""
        resolution = self._occupancy.resolution
        room = self._clearance_along(x, y, to_x, to_y)
        needed = min(self._body.passing_clearance, max(float(room[0]) - resolution, resolution / 2))
        return bool(room.min() >= needed)

    def _clearance_along(self, x: float, y: float, to_x: float, to_y: float) -> NDArray[np.float32]:
        """Return the clearance from walls along a straight line, m; 0 outside the map."""
        resolution = self._occupancy.resolution
        count = math.ceil(2.0 * math.hypot(to_x - x, to_y - y) / resolution) + 2
        start, end = np.array(((x,), (y,))), np.array(((to_x,), (to_y,)))
        line = np.arange(count) * ((end - start) / (count - 1)) + start
        line[:, -1:] = end
        cells = np.floor((line - self._corner) / resolution) + 1.0  # of the padded map
        col, row = np.minimum(np.maximum(cells, 0.0), self._last_cell).astype(np.intp)
        return np.asarray(self._padded.take(row * self._padded.shape[1] + col))


def _clearances(occupancy: OccupancyMap) -> NDArray[np.float32]:
    """Return (rows, cols) the clearance, m, of each free cell's centre from walls; else 0.

    Cells that are not known to be free have none, and the map's edge counts as a wall.
    """
    room = occupancy.distance_field() - occupancy.resolution / 2
    rows, cols = room.shape
    row, col = np.arange(rows)[:, None], np.arange(cols)[None, :]
    rim = np.minimum(np.minimum(row, rows - 1 - row), np.minimum(col, cols - 1 - col)) + 0.5
    room = np.minimum(room, rim * occupancy.resolution)
    return np.where(occupancy.cells == FREE, np.maximum(room, 0.0), 0.0).astype(np.float32)


def _cell_costs(
    clearance: NDArray[np.float32], goals: NDArray[np.bool_], body: BodySize
) -> NDArray[np.float64]:
    """Return (rows, cols) the cost factor of each cell, infinite where the body has no room.

    It is 1 where the body turns, and more the less room is beside it: the cheapest way through a
    narrow place is along its middle.
    """
    passable = (clearance >= body.passing_clearance) | (goals & (clearance > 0.0))
    span = max(body.turning_clearance - body.passing_clearance, 0.01)
    lack = (body.turning_clearance - clearance.astype(np.float64)) / span
    factor = 1.0 + (_NARROW_COST - 1.0) * np.clip(lack, 0.0, 1.0)
    return np.where(passable, factor, np.inf)


def _nearest_with_path(has_path: NDArray[np.bool_]) -> NDArray[np.int32]:
    """Return (rows, cols) the index of the nearest cell that has a path, -1 if none has."""
    if not has_path.any():
        return np.full(has_path.shape, NOWHERE, dtype=np.int32)
    _, labels = cv2.distanceTransformWithLabels(
        np.where(has_path, 0, 255).astype(np.uint8),
        cv2.DIST_L2,
        cv2.DIST_MASK_5,
        labelType=cv2.DIST_LABEL_PIXEL,
    )
    cell_of_label = np.zeros(int(labels.max()) + 1, dtype=np.int32)
    cells = np.flatnonzero(has_path)
    cell_of_label[labels.flat[cells]] = cells
    return np.asarray(cell_of_label[labels], dtype=np.int32)

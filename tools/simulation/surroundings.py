"""The simulated building as it is: a map, and the things drawn into it that no map shows."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from maps.border import Border
from maps.occupancy_map import FREE, OCCUPIED, OccupancyMap
from maps.pose import Pose
from tools.simulation.grid_rectangle import cells_in
from tools.simulation.truth.surroundings_truth import ThingsTruth

# Sizes are ours: what stands about in offices and laboratories.
_BOX = (0.20, 0.60)  # m, shortest and longest side
_TABLE = ((1.0, 1.6), (0.6, 0.8))  # m, lengths and widths
_LEG = 0.07  # m
_LOW_BOX = (0.25, 0.40)  # m
_DOOR = 0.90  # m
_WALL = 0.40  # m; an open door goes through walls up to so thick
_OPENING = 1.30  # m; the widest opening that a door shuts
_GLASS = 2.0  # m of wall
_NEAR_BORDER = 3.0  # m; farther away nobody would meet a thing
_WAY = 0.6  # m; a low box stands where robots drive
_TRIES = 300  # places looked at for each thing
_ONE_IN = 4  # things of which one may come nearer to the border


@dataclass(frozen=True, slots=True)
class Surroundings:
    """Three maps of the same cells: what bodies touch, what lasers see and what sonars hear."""

    touched: OccupancyMap
    seen: OccupancyMap
    heard: OccupancyMap


def surroundings_of(
    occupancy: OccupancyMap, border: Border | None, truth: ThingsTruth, rng: np.random.Generator
) -> Surroundings:
    """Return a map with the things that a truth adds to it, at places drawn near the border.

    Where a thing finds no room in 300 tries there is one fewer. Without a border there are none.
    """
    if border is None:
        return Surroundings(occupancy, occupancy, occupancy)
    placing = _Placing(occupancy, border, truth, rng)
    kinds: tuple[tuple[Callable[[float], bool], int], ...] = (
        (placing.open_door, truth.doors_open),
        (placing.shut_door, truth.doors_shut),
        (placing.table, truth.tables),
        (placing.box, truth.boxes),
        (placing.low_box, truth.low_boxes),
        (placing.glass, truth.glass),
    )
    number = 0
    for place, count in kinds:
        for _ in range(count):
            number += 1
            clearance = truth.clearance if number % _ONE_IN else truth.narrowest
            any(place(clearance) for _ in range(_TRIES))
    return placing.surroundings()


class _Placing:
    """Draws places and puts things there; each method tries one place and returns success."""

    def __init__(
        self, occupancy: OccupancyMap, border: Border, truth: ThingsTruth, rng: np.random.Generator
    ) -> None:
        self._map = occupancy
        self._truth = truth
        self._rng = rng
        self._touched, self._seen = occupancy.cells.copy(), occupancy.cells.copy()
        rows, cols = occupancy.cells.shape
        row, col = np.mgrid[:rows, :cols]
        middles = np.column_stack((col.ravel(), row.ravel())) + 0.5
        points = middles * occupancy.resolution + occupancy.origin[:2]
        _, distances = border.project_many(points)
        self._from_border: NDArray[np.float64] = distances.reshape(rows, cols)
        near = self._from_border < _NEAR_BORDER
        self._free = np.argwhere(near & (occupancy.cells == FREE))
        way = self._from_border < _WAY
        self._way = np.argwhere(way & (occupancy.cells == FREE))
        self._walls = np.argwhere(near & (occupancy.cells == OCCUPIED))

    def surroundings(self) -> Surroundings:
        """Return the maps with all things so far."""
        if (self._touched == self._map.cells).all() and (self._seen == self._map.cells).all():
            return Surroundings(self._map, self._map, self._map)
        touched = replace(self._map, cells=self._touched)
        return Surroundings(touched, replace(self._map, cells=self._seen), touched)

    def box(self, clearance: float) -> bool:
        """Put a box down."""
        length, width = self._rng.uniform(*_BOX, 2).tolist()
        place = self._some_place(self._free)
        return self._put([(place, length, width)], clearance)

    def low_box(self, _clearance: float) -> bool:
        """Put down a box that is lower than the laser's plane."""
        length, width = self._rng.uniform(*_LOW_BOX, 2).tolist()
        place = self._some_place(self._way)
        return self._put([(place, length, width)], self._truth.low_clearance, seen=False)

    def table(self, clearance: float) -> bool:
        """Put a table down: its four legs."""
        length, width = (float(self._rng.uniform(*sides)) / 2 for sides in _TABLE)
        place = self._some_place(self._free)
        legs = [place.compose(Pose(x, y, 0.0)) for x in (-length, length) for y in (-width, width)]
        return self._put([(leg, _LEG, _LEG) for leg in legs], clearance)

    def open_door(self, clearance: float) -> bool:
        """Open a door where the map has a wall between two free places."""
        place = self._some_place(self._walls)
        turned = place._replace(theta=float(self._rng.integers(4)) * math.pi / 2)
        hole = cells_in(self._map, turned, _WALL / 2, _DOOR / 2)
        sides = [turned.compose(Pose(x, 0.0, 0.0)) for x in (-_WALL / 2 - 0.1, _WALL / 2 + 0.1)]
        leads = all(
            (self._map.cells[cells_in(self._map, side, 0.05, _DOOR / 2)] == FREE).all()
            for side in sides
        )
        if not leads or self._from_border[hole].min() < clearance:
            return False
        self._touched[hole] = self._seen[hole] = FREE
        return True

    def shut_door(self, clearance: float) -> bool:
        """Shut an opening between two walls that the map has."""
        place = self._some_place(self._free)
        turned = place._replace(theta=float(self._rng.integers(2)) * math.pi / 2)
        line = cells_in(self._map, turned, _OPENING, self._map.resolution / 2)
        along = np.argsort(line[0] + line[1])  # one of the two is constant
        row, col = line[0][along], line[1][along]
        walls = np.flatnonzero(self._map.cells[row, col] == OCCUPIED)
        middle = len(row) // 2
        before, after = walls[walls < middle], walls[walls > middle]
        if not len(before) or not len(after):
            return False
        low, high = int(before[-1]), int(after[0])
        leaf = row[low : high + 1], col[low : high + 1]
        if (high - low) * self._map.resolution > _OPENING:
            return False
        if self._from_border[leaf].min() < clearance:
            return False
        self._touched[leaf] = self._seen[leaf] = OCCUPIED
        return True

    def glass(self, _clearance: float) -> bool:
        """Make a stretch of wall invisible to lasers."""
        place = self._some_place(self._walls)
        row, col = cells_in(self._map, place._replace(theta=0.0), _GLASS / 2, _GLASS / 2)
        walls = self._map.cells[row, col] == OCCUPIED
        row, col = row[walls], col[walls]
        # A straight stretch, not a corner or a pillar.
        if min(np.ptp(row), np.ptp(col)) * self._map.resolution > _WALL or len(row) < _GLASS / 0.05:
            return False
        self._seen[row, col] = FREE
        return True

    def _some_place(self, cells: NDArray[np.intp]) -> Pose:
        """Return the middle of one of cells (n, 2), with any direction."""
        row, col = cells[int(self._rng.integers(len(cells)))].tolist()
        x, y = self._map.centre(row, col)
        return Pose(x, y, float(self._rng.uniform(-math.pi, math.pi)))

    def _put(
        self, parts: list[tuple[Pose, float, float]], clearance: float, *, seen: bool = True
    ) -> bool:
        """Occupy the free cells under parts (place, length, width) unless the border is near."""
        for place, length, width in parts:
            cells = cells_in(self._map, place, length / 2, width / 2)
            free = len(cells[0]) and (self._touched[cells] == FREE).all()
            if not free or self._from_border[cells].min() < clearance:
                return False
        for place, length, width in parts:
            cells = cells_in(self._map, place, length / 2, width / 2)
            self._touched[cells] = OCCUPIED
            if seen:
                self._seen[cells] = OCCUPIED
        return True

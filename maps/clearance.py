"""Clearance of a border: the distance from each of its points to the nearest wall."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from maps.border import Border
from maps.occupancy_map import FREE, OCCUPIED, UNKNOWN, OccupancyMap

_KEPT_FREE = 0.08  # m beyond the corners of a robot that turns beside a wall
NEEDED_CLEARANCE = 0.45
"""m that a border for two-wheeled Pioneers keeps from all walls."""
_STEP = 0.01  # m along the border


def needed_clearance(reach: float) -> float:
    """Return the clearance, m, whole centimetres, that a robot needs to turn on the border.

    reach: distance of its farthest corner from the middle of the axle, m. It may be some way off
    the border, and its pose off by some centimetres.
    """
    return math.ceil(100.0 * (reach + _KEPT_FREE) - 1e-9) / 100.0


@dataclass(frozen=True, slots=True)
class BorderPlace:
    """A place on a border: x, y in m in the map frame, abscissa in m."""

    x: float
    y: float
    abscissa: float

    def __str__(self) -> str:
        return f"x {self.x:.2f}, y {self.y:.2f} (s = {self.abscissa:.2f} m)"


@dataclass(frozen=True, slots=True)
class NarrowStretch:
    """A stretch of a border with too little clearance: from and to abscissae, m, and its worst.

    least: m, at ``narrowest``.
    """

    start: float
    end: float
    least: float
    narrowest: BorderPlace

    def __str__(self) -> str:
        where = f"s = {self.start:.2f} to {self.end:.2f} m"
        return f"{where}: {self.least:.2f} m at x {self.narrowest.x:.2f}, y {self.narrowest.y:.2f}"


@dataclass(frozen=True, slots=True, eq=False)
class Clearance:
    """The clearance along a border.

    points (n, 2), abscissae (n,), distances (n,): m, at steps of 0.01 m; distance from the border
    to the nearest occupied cell's edge, 0 inside one, width plus height of the map if it has no
    wall. narrowest: where the distance is smallest. first_outside, first_unknown, first_occupied:
    where the border first leaves the map, enters unknown cells, enters a wall; None if it does not.
    """

    points: NDArray[np.float64]
    abscissae: NDArray[np.float64]
    distances: NDArray[np.float64]
    narrowest: BorderPlace
    first_outside: BorderPlace | None
    first_unknown: BorderPlace | None
    first_occupied: BorderPlace | None

    @property
    def minimum(self) -> float:
        """Smallest distance to a wall, m."""
        return float(self.distances.min())

    def narrow_stretches(self, needed: float) -> list[NarrowStretch]:
        """Return the stretches with less than a clearance, m, in order of abscissa."""
        narrow = np.concatenate(([False], self.distances < needed, [False]))
        begins = np.flatnonzero(narrow[1:] & ~narrow[:-1])
        ends = np.flatnonzero(narrow[:-1] & ~narrow[1:])
        return [
            self._stretch(begin, end)
            for begin, end in zip(begins.tolist(), ends.tolist(), strict=True)
        ]

    def _stretch(self, begin: int, end: int) -> NarrowStretch:
        worst = begin + int(np.argmin(self.distances[begin:end]))
        x, y = self.points[worst].tolist()
        s = self.abscissae
        return NarrowStretch(
            start=float(s[begin]),
            end=float(s[end - 1]),
            least=float(self.distances[worst]),
            narrowest=BorderPlace(x, y, float(s[worst])),
        )


def border_clearance(occupancy: OccupancyMap, border: Border) -> Clearance:
    """Measure the clearance along a border on a map.

    The distance field is interpolated bilinearly at the border's points, less half a cell, because
    it holds distances to the centres of occupied cells.
    """
    points = border.polyline(_STEP)
    abscissae = np.linspace(0.0, border.length, len(points))
    rows, cols = occupancy.cells_at(points)
    inside = occupancy.inside(rows, cols)
    states = np.full(len(points), FREE, dtype=np.uint8)
    states[inside] = occupancy.cells[rows[inside], cols[inside]]
    field = np.minimum(occupancy.distance_field(), sum(occupancy.size))  # inf * 0 is nan
    to_centers = _interpolate(occupancy, field, points)
    distances = np.maximum(to_centers - occupancy.resolution / 2, 0.0)
    distances[states == OCCUPIED] = 0.0

    def place(index: np.intp) -> BorderPlace:
        x, y = points[index]
        return BorderPlace(float(x), float(y), float(abscissae[index]))

    def first(where: NDArray[np.bool_]) -> BorderPlace | None:
        return place(np.argmax(where)) if where.any() else None

    return Clearance(
        points=points,
        abscissae=abscissae,
        distances=distances,
        narrowest=place(np.argmin(distances)),
        first_outside=first(~inside),
        first_unknown=first(states == UNKNOWN),
        first_occupied=first(states == OCCUPIED),
    )


def _interpolate(
    occupancy: OccupancyMap, field: NDArray[np.float32], points: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return (n,) values of a field of cell centres at points (n, 2), clamped at its edge."""
    limits = np.array(field.shape[::-1]) - 1
    place = (points - occupancy.origin[:2]) / occupancy.resolution - 0.5
    place = np.clip(place, 0.0, limits)
    low = np.minimum(place.astype(np.intp), np.maximum(limits - 1, 0))
    high = np.minimum(low + 1, limits)
    right, up = (place - low).T
    (col0, row0), (col1, row1) = low.T, high.T
    bottom = field[row0, col0] * (1.0 - right) + field[row0, col1] * right
    top = field[row1, col0] * (1.0 - right) + field[row1, col1] * right
    return np.asarray(bottom * (1.0 - up) + top * up, dtype=np.float64)

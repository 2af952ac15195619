"""Lines of sight between robots' bodies: what walls and third bodies hide."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from maps.occupancy_map import OCCUPIED, OccupancyMap

OCCLUSION_RADIUS = 0.20
"""m; half a Pioneer's width: a line nearer to a body's centre is occluded."""
_SAMPLES = 32  # along a line of sight; at most 0.13 m apart over the detection range

Array = NDArray[np.float64]


class SightLines:
    """The cells of a map that lines of sight do not pass.

    opaque: (rows, cols) of the map, padded by a cell on every side. resolution: m of a cell.
    """

    def __init__(self, detection_range: float, occupancy: OccupancyMap) -> None:
        """detection_range: m; the longest line."""
        self._origin = np.array((occupancy.origin.x, occupancy.origin.y))
        self.resolution = occupancy.resolution
        walls = np.pad(occupancy.cells == OCCUPIED, 1, constant_values=True)
        spacing = detection_range / (_SAMPLES - 1)
        # Lines are sampled: a wall nearer than half the spacing may lie between two samples.
        room = np.pad(occupancy.distance_field(), 1) - occupancy.resolution / 2.0
        self.opaque = walls | (room < spacing / 2.0)
        self._flat, self._columns = self.opaque.ravel(), self.opaque.shape[1]
        self._last_cell = np.array(self.opaque.shape[::-1]) - 1.0
        self._shares = np.linspace(0.0, 1.0, _SAMPLES)

    def cells(self, points: Array) -> NDArray[np.intp]:
        """Return (m,) the flat indices in ``opaque`` of points (2, m), m, map frame."""
        return self._flat_indices((points - self._origin[:, None]) / self.resolution + 1.0)

    def are_behind_wall(self, start: Array, way: Array) -> NDArray[np.bool_]:
        """Return (m,) whether a wall lies on the lines from start (2, m) along way (2, m)."""
        origin = self._origin[:, None]
        first, last = ((place - origin) / self.resolution for place in (start, start + way))
        cells = first[:, :, None] + (last - first)[:, :, None] * self._shares + 1.0
        return np.asarray(self._flat.take(self._flat_indices(cells)).any(axis=1))

    def _flat_indices(self, cells: Array) -> NDArray[np.intp]:
        last = self._last_cell.reshape(2, *[1] * (cells.ndim - 1))
        col, row = np.minimum(np.maximum(cells, 0.0), last).astype(np.intp)
        return np.asarray(row * self._columns + col)


def pass_near(start: Array, way: Array, bodies: Array) -> NDArray[np.bool_]:
    """Return whether lines from start (2, ...) along way (2, ...) are occluded by bodies.

    bodies: (2, ...) centres, m; all broadcast to the shape of the result.
    """
    length2 = np.maximum(way[0] ** 2 + way[1] ** 2, 1e-12)
    x, y = bodies[0] - start[0], bodies[1] - start[1]
    share = np.minimum(np.maximum((x * way[0] + y * way[1]) / length2, 0.0), 1.0)
    return np.asarray(np.hypot(x - share * way[0], y - share * way[1]) < OCCLUSION_RADIUS)

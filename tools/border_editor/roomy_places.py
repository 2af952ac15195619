"""The places of a map that are far enough from all walls for a border."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from maps.occupancy_map import FREE, OccupancyMap

MARGIN = 0.05
"""m kept beyond the clearance that is needed: where there is room, nobody draws along the limit."""


class RoomyPlaces:
    """Cells whose clearance is enough; ``room``: (rows, cols) m of each, 0 where nothing is known.

    ``mask``: (rows, cols), which have enough.
    """

    def __init__(self, occupancy: OccupancyMap, needed: float, margin: float = MARGIN) -> None:
        """Measure a map; needed: clearance, m, that robots need, with a margin, m."""
        self._occupancy = occupancy
        known = occupancy.cells == FREE
        walls = np.minimum(occupancy.distance_field(), sum(occupancy.size))
        self.room: NDArray[np.float64] = np.where(known, walls - occupancy.resolution / 2, 0.0)
        self.mask: NDArray[np.bool_] = self.room >= needed + margin

    def nearest(self, x: float, y: float) -> tuple[float, float] | None:
        """Return (x, y), m, if it has enough room, else the nearest place that has; None: none."""
        cells = np.argwhere(self.mask)
        if not len(cells):
            return None
        rows, cols = self._occupancy.cells_at((x, y))
        if self._occupancy.inside(rows, cols)[0] and self.mask[rows[0], cols[0]]:
            return x, y
        places = self._occupancy.centres(cells)
        best = int(np.argmin(np.hypot(*(places - (x, y)).T)))
        return float(places[best, 0]), float(places[best, 1])

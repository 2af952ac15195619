"""Distance of each cell's centre from the mapped surface, where the beams of a laser end.

In a drawn map walls are solid, and a beam ends on the face of the first occupied cell: the
distance is signed, negative inside a wall, and its interpolation between the cells' centres is 0
on the face. In a map built from scans an occupied cell is one in which beams ended, anywhere in
it: the distance is that from the middle of the cell.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from maps.occupancy_map import FREE, OCCUPIED, OccupancyMap, Surface, distances_to


@lru_cache(maxsize=4)
def surface_distance(occupancy: OccupancyMap) -> NDArray[np.float32]:
    """Return (rows, cols) distances, m, of the cells' centres from the mapped surface.

    Where the surface is the walls' faces, those to free cells: negative in the walls and beyond.
    Infinite without a surface. Read-only, and computed once for a map: the parts of a localizer
    share it, and so do those of a whole bench.
    """
    if occupancy.surface is Surface.CENTRE:
        return _read_only(occupancy.distance_field())
    occupied, free = occupancy.cells == OCCUPIED, occupancy.cells == FREE
    # Of a wall to unknown ground only the face to the free side is seen.
    in_cells = np.where(
        free,
        _distances_to_squares(occupied),
        -_distances_to_squares(free & _beside(occupied)),
    )
    return _read_only(np.asarray(in_cells * occupancy.resolution, dtype=np.float32))


def _read_only(distances: NDArray[np.float32]) -> NDArray[np.float32]:
    distances.setflags(write=False)
    return distances


def _beside(cells: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return (rows, cols) which cells share a side with a chosen one."""
    padded = np.pad(cells, 1)
    return padded[:-2, 1:-1] | padded[2:, 1:-1] | padded[1:-1, :-2] | padded[1:-1, 2:]


def _distances_to_squares(cells: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Return (rows, cols) distances, in cells, of each centre from the nearest chosen cell.

    The point of a cell nearest to another cell's centre is one of its corners or the middle of a
    side: all are points of a grid of half a cell.
    """
    rows, cols = cells.shape
    points = np.zeros((2 * rows + 1, 2 * cols + 1), dtype=np.bool_)
    for up in range(3):
        for across in range(3):
            points[up : up + 2 * rows - 1 : 2, across : across + 2 * cols - 1 : 2] |= cells
    return distances_to(points, step=2) / 2.0

"""What the localizer knows of a map's cells: state and distance from the mapped surface, 2 bytes.

Cells beyond what is known, by more than distances are cut at, are left out: they tell nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from localization.surface_distance import FAR, reach_in_cells, surface_distance
from maps.occupancy_map import UNKNOWN, OccupancyMap

DISTANCE_BITS = 13
DISTANCE_MASK = (1 << DISTANCE_BITS) - 1
ON_SURFACE = DISTANCE_MASK // 2
"""Distance code of a cell on the surface; it grows with the distance, by ``DISTANCE_STEP``."""
DISTANCE_STEP = FAR / ON_SURFACE  # m; 0.1 mm
_FAR_CODE = 2 * ON_SURFACE
_BAND = 256  # rows computed at once, to fit a core's cache


@dataclass(frozen=True, slots=True, eq=False)
class CellTable:
    """State and distance of each known cell, with a rim of unknown ones, FAR from the surface."""

    codes: NDArray[np.uint16]
    """(rows, cols) state << DISTANCE_BITS | distance code; row 0 is the bottom."""
    corner: complex
    """Lower-left corner of cell (0, 0), x + iy, m, map frame."""
    resolution: float
    """Side of a cell, m."""


def distance_code(distance: float) -> int:
    """Return the code of a distance from the surface, m, -FAR to FAR."""
    return ON_SURFACE + round(distance / DISTANCE_STEP)


@lru_cache(maxsize=4)
def cell_table(occupancy: OccupancyMap) -> CellTable:
    """Return the table of a map, read-only.

    It is computed once for a map: the parts of a localizer share it, and so do the robots of a
    bench.
    """
    resolution = occupancy.resolution
    first_row, first_col, cells = _known(occupancy)
    height, width = cells.shape
    codes = np.empty((height + 2, width + 2), np.uint16)
    reach = reach_in_cells(resolution)
    for start in range(0, height, _BAND):
        low, end = max(start - reach, 0), min(start + _BAND, height)
        some = cells[low : end + reach]
        distance = surface_distance(some, resolution, occupancy.surface)[start - low : end - low]
        code = np.rint(distance * np.float32(1.0 / DISTANCE_STEP)).astype(np.int16) + ON_SURFACE
        state = cells[start:end].astype(np.uint16) << DISTANCE_BITS
        codes[1 + start : 1 + end, 1:-1] = state | code.view(np.uint16)
    codes[0, 1:-1], codes[-1, 1:-1] = _beyond(codes[1, 1:-1]), _beyond(codes[-2, 1:-1])
    codes[:, 0], codes[:, -1] = _beyond(codes[:, 1]), _beyond(codes[:, -2])
    codes.setflags(write=False)
    corner = complex(
        occupancy.origin.x + (first_col - 1) * resolution,
        occupancy.origin.y + (first_row - 1) * resolution,
    )
    return CellTable(codes, corner, resolution)


def _known(occupancy: OccupancyMap) -> tuple[int, int, NDArray[np.uint8]]:
    """Return the cells up to FAR round all known ones, and the first row and column of them."""
    known = occupancy.cells != UNKNOWN
    rows, cols = np.flatnonzero(known.any(axis=1)), np.flatnonzero(known.any(axis=0))
    if len(rows) == 0:
        return 0, 0, occupancy.cells[:1, :1]
    margin = reach_in_cells(occupancy.resolution)
    row, col = max(int(rows[0]) - margin, 0), max(int(cols[0]) - margin, 0)
    return row, col, occupancy.cells[row : rows[-1] + margin + 1, col : cols[-1] + margin + 1]


def _beyond(edge: NDArray[np.uint16]) -> NDArray[np.uint16]:
    """Return the codes of unknown cells beside those of an edge, on the same side of the surface.

    Else the interpolated distance would pass through 0 between them.
    """
    outside = (edge & DISTANCE_MASK) >= ON_SURFACE
    return np.where(outside, np.uint16(_FAR_CODE), np.uint16(0)) | np.uint16(
        UNKNOWN << DISTANCE_BITS
    )

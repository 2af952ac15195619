"""The cells of a map that a rectangle covers."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from maps.occupancy_map import OccupancyMap
from maps.pose import Pose


def cells_in(
    occupancy: OccupancyMap, middle: Pose, half_length: float, half_width: float
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return rows and columns of the cells whose middles lie in a rectangle about a pose, m."""
    rows, cols = occupancy.cells.shape
    reach = math.hypot(half_length, half_width)
    size, origin = occupancy.resolution, occupancy.origin
    low_row, low_col = (
        max(0, math.floor((at - start - reach) / size))
        for at, start in ((middle.y, origin.y), (middle.x, origin.x))
    )
    high_row = min(rows, math.ceil((middle.y - origin.y + reach) / size))
    high_col = min(cols, math.ceil((middle.x - origin.x + reach) / size))
    row, col = np.mgrid[low_row:high_row, low_col:high_col]
    dx = origin.x + (col + 0.5) * size - middle.x
    dy = origin.y + (row + 0.5) * size - middle.y
    c, s = math.cos(middle.theta), math.sin(middle.theta)
    inside = np.abs(c * dx + s * dy) <= half_length + 1e-9
    inside &= np.abs(c * dy - s * dx) <= half_width + 1e-9
    return row[inside], col[inside]

"""Distance from the mapped surface as a continuous function of position, with its gradient."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from localization.cell_table import DISTANCE_MASK, DISTANCE_STEP, ON_SURFACE, cell_table
from maps.occupancy_map import OccupancyMap
from maps.pose import Pose


class DistanceSurface:
    """The distance from the mapped surface, interpolated bilinearly between the cells' centres.

    The gradient is that of the interpolation: differences of neighbouring cells would vanish on a
    wall, where Gauss-Newton needs the gradient most, and make its steps overshoot.
    """

    def __init__(self, occupancy: OccupancyMap) -> None:
        """Prepare a map; distances are cut at ``surface_distance.FAR``, outside it as well."""
        table = cell_table(occupancy)
        rows, cols = table.codes.shape
        self._flat = table.codes.ravel()
        self._cols = cols
        self._corners = np.array([[0], [1], [cols], [cols + 1]])
        self._last = (cols - 1.01, rows - 1.01)
        self._scale = np.float32(1.0 / table.resolution)
        self._step = np.float32(DISTANCE_STEP)
        self._slope = np.float32(DISTANCE_STEP / table.resolution)
        # Centre of the lower-left cell.
        self._corner = table.corner + 0.5 * table.resolution * (1.0 + 1.0j)

    def sample(
        self, pose: Pose, arms: NDArray[np.complex64]
    ) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]:
        """Return (m,) gradient along x, gradient along y, m/m, and distance, m, at map positions.

        The distance is negative inside walls whose faces are the surface.

        The positions are ``arms`` (m,), x + iy along the map's axes, m, relative to a pose.
        """
        pixels = (arms + np.complex64(complex(pose.x, pose.y) - self._corner)) * self._scale
        across = np.minimum(np.maximum(pixels.real, 0.0), self._last[0])
        up = np.minimum(np.maximum(pixels.imag, 0.0), self._last[1])
        column, row = np.floor(across), np.floor(up)
        cell = row.astype(np.intp) * self._cols + column.astype(np.intp)
        codes = self._flat.take(self._corners + cell, mode="clip") & DISTANCE_MASK
        low_left, low_right, high_left, high_right = codes.astype(np.float32)
        across -= column
        up -= row
        low_rise, high_rise = low_right - low_left, high_right - high_left
        low, high = low_left + across * low_rise, high_left + across * high_rise
        slope_y = high - low
        slope_x = low_rise + up * (high_rise - low_rise)
        distance = (low + up * slope_y - np.float32(ON_SURFACE)) * self._step
        return slope_x * self._slope, slope_y * self._slope, distance

"""Distance from the mapped surface as a continuous function of position, with its gradient."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from localization.surface_distance import surface_distance
from maps.occupancy_map import OccupancyMap
from maps.pose import Pose


class DistanceSurface:
    """The distance from the mapped surface, interpolated bilinearly between the cells' centres.

    The gradient is that of the interpolation: differences of neighbouring cells would vanish on a
    wall, where Gauss-Newton needs the gradient most, and make its steps overshoot.
    """

    def __init__(self, occupancy: OccupancyMap, far: float) -> None:
        """Prepare a map; distances are cut at ``far`` m, which also holds outside the map."""
        field = np.clip(surface_distance(occupancy), np.float32(-far), np.float32(far))
        padded = np.pad(field, 1, constant_values=far)
        rows, cols = padded.shape
        self._flat = padded.ravel()
        self._cols = cols
        self._corners = np.array([[0], [1], [cols], [cols + 1]])
        self._last = (cols - 1.01, rows - 1.01)
        self._scale = np.float32(1.0 / occupancy.resolution)
        # Centre of the padding's lower-left cell.
        half = 0.5 * occupancy.resolution
        self._corner = complex(occupancy.origin.x - half, occupancy.origin.y - half)

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
        low_left, low_right, high_left, high_right = self._flat.take(
            self._corners + cell, mode="clip"
        )
        across -= column
        up -= row
        low_rise, high_rise = low_right - low_left, high_right - high_left
        low, high = low_left + across * low_rise, high_left + across * high_rise
        slope_y = high - low
        slope_x = low_rise + up * (high_rise - low_rise)
        return slope_x * self._scale, slope_y * self._scale, low + up * slope_y

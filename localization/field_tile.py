"""The part of a likelihood field in use: an image of log-likelihoods round the robot.

A field of a whole large map, a number of 4 bytes a cell, would take twice the memory of all else.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from localization.cell_table import CellTable

MAX_CELLS = 1 << 22  # 100 x 100 m of 0.05 m, 16 MB
MARGIN = 10.0  # m beyond the end points, until another tile is needed
_WORTH_IT = 100  # particles; for fewer ones no tile is made


@dataclass(frozen=True, slots=True, eq=False)
class Tile:
    """The log-likelihoods of end points in a part of a map's cells."""

    image: NDArray[np.float32]
    column: int
    row: int
    """The table's column and row of its first cell."""

    def holds(self, low: tuple[int, int], high: tuple[int, int]) -> bool:
        """Whether it has the cells from a column and row to before others."""
        rows, cols = self.image.shape
        starts = self.column <= low[0] and self.row <= low[1]
        return starts and high[0] <= self.column + cols and high[1] <= self.row + rows


class FieldTile:
    """Keeps a tile of the field where it was asked for last."""

    def __init__(self, table: CellTable, log_of_code: NDArray[np.float32]) -> None:
        """Prepare a map's table; log_of_code: log-likelihood by a cell's code."""
        self._table = table
        self._log_of_code = log_of_code
        rows, cols = table.codes.shape
        self._end = cols, rows
        self._has_all = rows * cols <= MAX_CELLS
        self._tile = self._of((0, 0), self._end) if self._has_all else None

    def round(self, particles: NDArray[np.float64], radius: float) -> Tile | None:
        """Return a tile with all cells within radius, m, of particles (n, 3).

        None if it would be too large, or is not worth it.
        """
        if self._has_all:
            return self._tile
        low, high = self._box(particles, radius)
        if self._tile is None or not self._tile.holds(low, high):
            low, high = self._box(particles, radius + MARGIN)
            cells = (high[0] - low[0]) * (high[1] - low[1])
            if len(particles) < _WORTH_IT or not 0 < cells <= MAX_CELLS:
                return None
            self._tile = self._of(low, high)
        return self._tile

    def _box(
        self, particles: NDArray[np.float64], radius: float
    ) -> tuple[tuple[int, int], tuple[int, int]]:
        """Return the first column and row of the cells within radius, m, and those behind them."""
        scale, corner = 1.0 / self._table.resolution, self._table.corner
        low, high = [], []
        for axis, start in enumerate((corner.real, corner.imag)):
            values, end = particles[:, axis], self._end[axis]
            first = math.floor((float(values.min()) - radius - start) * scale)
            last = math.floor((float(values.max()) + radius - start) * scale)
            low.append(min(max(first, 0), end))
            high.append(min(max(last + 1, 0), end))
        return (low[0], low[1]), (high[0], high[1])

    def _of(self, low: tuple[int, int], high: tuple[int, int]) -> Tile:
        codes = self._table.codes[low[1] : high[1], low[0] : high[0]]
        return Tile(self._log_of_code.take(codes), *low)

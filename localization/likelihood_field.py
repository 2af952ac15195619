"""Likelihood field: log-likelihood of a scan's end points for many poses at once.

Thrun, Burgard, Fox, "Probabilistic Robotics", section 6.4 (likelihood_field_range_finder_model).
The field is an image of a beam's log-likelihood by its end point; a scan seen from n particles is
one matrix product and one gather from it. Particles all over a large map, of which there is no such
image, are looked up in two steps: cell, then likelihood.

In a crowd people stand, by chance, on the walls of wrong poses. So beams through walls can be
counted as well (section 6.3, beam_range_finder_model): people explain a beam that is too short, and
not one that is too long.
"""

from __future__ import annotations

import math
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from localization.cell_table import DISTANCE_BITS, DISTANCE_STEP, ON_SURFACE, cell_table
from localization.field_tile import FieldTile, Tile
from localization.ray_table import RayTable
from maps.occupancy_map import UNKNOWN, OccupancyMap

SIGMA = 0.1  # m; of an end point, from laser, map and particle spacing together
RANDOM_SHARE = 0.1  # of the beams, ending anywhere: on people, on teammates
THROUGH_SHARE = 0.01  # of the beams, through walls: a wall that is seen through is a rarer error
_CHUNK = 1 << 17  # products looked up at once, to fit a core's cache
_WIDEST = 32766  # maximum columns of cv2.remap's result


class LikelihoodField:
    """Log-likelihoods of end points by table look-up in the nearest cell."""

    def __init__(self, occupancy: OccupancyMap, beams: int) -> None:
        """Prepare a map.

        beams: maximum number of a scan's beams used, unless ``log_weights`` gets another.
        """
        self._beams = beams
        self._table = cell_table(occupancy)
        distance = (np.arange(1 << DISTANCE_BITS) - ON_SURFACE) * DISTANCE_STEP
        fit = np.exp(-0.5 * np.square(distance / SIGMA))
        log_of_distance = np.log((1.0 - RANDOM_SHARE) * fit + RANDOM_SHARE)
        # A code begins with the cell's state, on which the likelihood does not depend.
        self._log_of_code = np.tile(log_of_distance.astype(np.float32), UNKNOWN + 1)
        self._tile = FieldTile(self._table, self._log_of_code)
        self._rays = RayTable(self._table)
        # Kept buffers: allocating new ones at every scan takes longer than the computation.
        self._columns, self._rows, self._looked_up = np.empty((3, _CHUNK), dtype=np.float32)
        self._codes = np.empty(0, dtype=np.uint16)

    def log_weights(
        self,
        particles: NDArray[np.float64],
        points: NDArray[np.float64],
        independent_beams: float,
        beams: int | None = None,
        *,
        through_walls: bool = False,
    ) -> NDArray[np.float64]:
        """Return (n,) log-likelihoods of the scan for particles (n, 3) (map_from_base).

        points: (m, 2) end points in base_link, m. The product over the beams is tempered to the
        information of ``independent_beams``: neighbouring beams hit the same surface with
        correlated errors, so that a plain product would be overconfident. beams: maximum number of
        beams used; None: as constructed. through_walls: whether a beam through a mapped wall counts
        by that, and not by its end alone; takes 30 times as long. All zero without points.
        """
        points = spread_evenly(points, min(beams or self._beams, _CHUNK))
        if len(points) == 0:
            return np.zeros(len(particles))
        exponent = min(1.0, independent_beams / len(points))
        weight = np.full(len(points), exponent, dtype=np.float32)
        homogeneous = np.ones((len(points), 3), dtype=np.float32)
        homogeneous[:, :2] = points
        tile = self._tile.round(particles, float(np.hypot(*points.T).max()))
        to_column, to_row = self._pixels_from_base(particles, tile)
        # Rays are cast once for all particles: those of different chunks share their places.
        through = self._rays.through(particles, points) if through_walls else None
        total = np.empty(len(particles))
        step = min(_WIDEST, _CHUNK // len(points))
        for start in range(0, len(particles), step):
            some = slice(start, start + step)
            looked_up = self._look_up(homogeneous, to_column[:, some], to_row[:, some], tile)
            if through is not None:
                np.putmask(looked_up, through[:, some], math.log(THROUGH_SHARE))
            total[some] = weight @ looked_up
        return total

    def _look_up(
        self,
        homogeneous: NDArray[np.float32],
        to_column: NDArray[np.float32],
        to_row: NDArray[np.float32],
        tile: Tile | None,
    ) -> NDArray[np.float32]:
        """Return (m, n) log-likelihoods of points (m, 3) as (x, y, 1) by factors (3, n) of each.

        The end points of one beam lie close together for all particles: in this order the look-ups
        stay in the cache. The result is valid until the next call.
        """
        shape = len(homogeneous), to_column.shape[1]
        columns, rows, looked_up = (
            kept[: shape[0] * shape[1]].reshape(shape)
            for kept in (self._columns, self._rows, self._looked_up)
        )
        np.matmul(homogeneous, to_column, out=columns)
        np.matmul(homogeneous, to_row, out=rows)
        if tile is not None:
            return _nearest(tile.image, columns, rows, looked_up, float(self._log_of_code[-1]))
        if self._codes.size == 0:
            self._codes = np.empty(_CHUNK, dtype=np.uint16)
        codes = self._codes[: looked_up.size].reshape(shape)
        _nearest(self._table.codes, columns, rows, codes, float(self._table.codes[0, 0]))
        return np.take(self._log_of_code, codes, out=looked_up, mode="clip")

    def _pixels_from_base(
        self, poses: NDArray[np.float64], tile: Tile | None
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Return (3, n) factors of a point (x, y, 1) in base_link, seen from poses (n, 3).

        The first array gives its column, the other its row, in pixels of the tile, or of the whole
        map; (0, 0) is the centre of the lower-left cell.
        """
        heading = poses[:, 2].astype(np.float32)
        resolution, corner = self._table.resolution, self._table.corner
        scale = np.float32(1.0 / resolution)
        cosine, sine = np.cos(heading) * scale, np.sin(heading) * scale
        to_column = np.empty((3, len(poses)), dtype=np.float32)
        to_row = np.empty_like(to_column)
        to_column[0], to_row[0] = cosine, sine
        np.negative(sine, out=to_column[1])
        to_row[1] = cosine
        column, row = (0, 0) if tile is None else (tile.column, tile.row)
        to_column[2] = (poses[:, 0] - corner.real) / resolution - (column + 0.5)
        to_row[2] = (poses[:, 1] - corner.imag) / resolution - (row + 0.5)
        return to_column, to_row


def _nearest(
    image: NDArray[Any],
    columns: NDArray[np.float32],
    rows: NDArray[np.float32],
    out: NDArray[Any],
    outside: float,
) -> NDArray[Any]:
    """Return ``out`` (m, n) with the image's pixels nearest to columns and rows (m, n)."""
    cv2.remap(
        image,
        columns,
        rows,
        cv2.INTER_NEAREST,
        out,
        borderMode=cv2.BORDER_CONSTANT,
        borderValue=outside,
    )
    return out


def spread_evenly(points: NDArray[np.float64], count: int) -> NDArray[np.float64]:
    """Return at most ``count`` of points (m, 2), evenly spread over their order."""
    if len(points) <= count:
        return points
    return np.asarray(points[np.arange(count) * len(points) // count])

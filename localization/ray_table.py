"""Distances to the first mapped wall round many poses: which of their beams pass through walls.

Rays are cast from the cells of a coarse grid that the poses lie in, in all directions, and not
from each pose: particles lie close together. A ray advances by the distance to the nearest mapped
surface (sphere tracing: Hart, "Sphere tracing", The Visual Computer 12, 1996).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from localization.cell_table import (
    DISTANCE_BITS,
    DISTANCE_MASK,
    DISTANCE_STEP,
    ON_SURFACE,
    CellTable,
)
from localization.kld import bin_keys
from maps.occupancy_map import OCCUPIED

PLACE = 0.1  # m; side of the coarse grid's cells
DIRECTIONS = 360  # rays from each
REACH = 20.0  # m; a ray without a wall so far ends there
MOST_PLACES = 200  # cells; casting takes 65 us each, a scan is to take no more than 15 ms
MARGIN = 0.3  # m; a beam so much longer than its ray passes through the wall


class RayTable:
    """Casts rays on one map."""

    def __init__(self, table: CellTable) -> None:
        self._codes = table.codes
        self._corner, self._scale = table.corner, 1.0 / table.resolution
        self._resolution = table.resolution
        turn = np.arange(DIRECTIONS) * (math.tau / DIRECTIONS)
        self._directions = np.exp(1j * turn).astype(np.complex64)

    def through(
        self, particles: NDArray[np.float64], points: NDArray[np.float64]
    ) -> NDArray[np.bool_]:
        """Return (m, n) which beams to points (m, 2), m, base_link, pass through mapped walls.

        particles: (n, 3) map_from_base. None are found where particles lie in more than MOST_PLACES
        cells: so wide a belief is narrowed by the beams' ends first.
        """
        limits = np.hypot(*points.T).astype(np.float32) - np.float32(MARGIN)
        keys = bin_keys(particles * (1.0, 1.0, 0.0), PLACE, math.tau)
        _, first, place = np.unique(keys, return_index=True, return_inverse=True)
        if len(first) > MOST_PLACES:
            return np.zeros((len(points), len(particles)), dtype=np.bool_)
        centres = (np.floor(particles[first, :2] / PLACE) + 0.5) * PLACE
        ranges = self._cast(centres, float(limits.max(initial=0.0)))
        # A beam lies between two rays; along a wall the longer one is several times the other.
        ranges = np.maximum(ranges, np.roll(ranges, -1, axis=1))
        # Two turns of directions, so that heading and bearing need only be added.
        twice = np.hstack((ranges, ranges, ranges[:, :1]))
        headings = _in_directions(particles[:, 2])
        bearings = _in_directions(np.arctan2(points[:, 1], points[:, 0]))
        index = (headings + bearings[:, np.newaxis]).astype(np.int32)
        index += place.astype(np.int32) * np.int32(twice.shape[1])
        return np.asarray(twice.take(index) < limits[:, np.newaxis])

    def _cast(self, places: NDArray[np.float64], longest: float) -> NDArray[np.float32]:
        """Return (k, DIRECTIONS) distances of the first wall from places (k, 2), m; inf: none.

        longest: m, as far as the rays are cast.
        """
        longest = min(longest, REACH)
        height, width = self._codes.shape
        starts = ((places[:, 0] + 1j * places[:, 1]) - self._corner).astype(np.complex64)
        count = len(places) * DIRECTIONS
        ranges = np.full(count, np.inf, np.float32)
        # The rays still on their way.
        rays, along = np.arange(count), np.zeros(count, np.float32)
        starts, directions = (
            np.repeat(starts, DIRECTIONS),
            np.tile(self._directions, len(places)),
        )
        scale, least = np.float32(self._scale), np.float32(0.5 * self._resolution)
        # The distance is that between centres of cells, from which ray and wall may be off.
        inset = np.float32(1.5 * self._resolution)
        while len(rays):
            pixels = (starts + directions * along) * scale
            rows = np.clip(pixels.imag.astype(np.int32), 0, height - 1)
            cols = np.clip(pixels.real.astype(np.int32), 0, width - 1)
            codes = self._codes.take(rows * width + cols)
            hit = codes >> DISTANCE_BITS == OCCUPIED
            ranges[rays[hit]] = along[hit]
            distance = (codes & DISTANCE_MASK).astype(np.float32) - np.float32(ON_SURFACE)
            along = along + np.maximum(np.abs(distance) * np.float32(DISTANCE_STEP) - inset, least)
            on = ~hit & (along < longest)
            rays, along, starts, directions = rays[on], along[on], starts[on], directions[on]
        return ranges.reshape(len(places), DIRECTIONS)


def _in_directions(angles: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return angles (n,), rad, as numbers of directions, 0 to DIRECTIONS."""
    return np.mod(angles * (DIRECTIONS / math.tau), DIRECTIONS).astype(np.float32)

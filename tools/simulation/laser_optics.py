"""How lasers see the walls of the simulated world: surfaces, edges and noise."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from maps.occupancy_map import OccupancyMap
from tools.simulation.reflecting_tape import BeamEnds
from tools.simulation.truth.surroundings_truth import OpticsTruth

_STRETCH = 1.0  # m of wall that are of one surface; ours
_JUMP = 0.15  # m between neighbouring beams from which on there is an edge; ours
_STANDS_OUT = 3.0  # times that the step at an edge is larger than the smaller one beside it; ours
_NOISE_DOUBLES = 16.0
"""m of range that add the noise at range 0 again: with the 5 mm of SICK's data sheet for up to 8 m
it is 7.5 mm there; ours."""


class LaserOptics:
    """The surfaces of a map's walls, drawn once."""

    def __init__(
        self, occupancy: OccupancyMap, truth: OpticsTruth, rng: np.random.Generator
    ) -> None:
        """Draw the surface of each stretch of wall. The truth has at least one surface."""
        surfaces = list(truth.surfaces.values())
        shares = np.array([surface.share for surface in surfaces])
        rows, cols = (
            math.ceil(cells * occupancy.resolution / _STRETCH) + 1
            for cells in occupancy.cells.shape
        )
        kinds = rng.choice(len(surfaces), rows * cols, p=shares / shares.sum())
        self._columns, self._no_wall = cols, rows * cols
        self._origin = occupancy.origin
        self._resolution = occupancy.resolution
        # What is no wall comes last: always seen, with the noise of the laser alone.
        self._offset = np.append([surfaces[kind].offset for kind in kinds], 0.0)
        self._noise = np.append([surfaces[kind].noise for kind in kinds], 0.0)
        self._reach = np.append([surfaces[kind].reach for kind in kinds], np.inf)
        self._facing = np.append([math.cos(surfaces[kind].facing) for kind in kinds], 0.0)
        self._glare = np.append([math.cos(surfaces[kind].glare) for kind in kinds], 1.0)
        self._facing -= 1e-6  # a beam along a surface hits it within rounding
        self._mixed = truth.mixed

    def measured(
        self,
        ranges: NDArray[np.float64],
        ends: tuple[NDArray[np.float64], NDArray[np.float64]],
        directions: tuple[NDArray[np.float64], NDArray[np.float64]],
        on_wall: NDArray[np.bool_],
        firsts: Sequence[int],
        noise: float,
        rng: np.random.Generator,
    ) -> NDArray[np.float64]:
        """Return what lasers measure of true ranges (n,), m; inf where nothing returns.

        ends: x and y (n,), m, map frame, of where beams end; of one without an end it is anything.
        directions: cosine and sine (n,) of the beams' directions. on_wall (n,): whether that is
        on a wall. firsts: index of each laser's first beam. noise: m, of every surface at once
        before the laser.
        """
        seen = np.isfinite(ranges)
        x = np.where(seen, ends[0] - self._origin.x, 0.0)
        y = np.where(seen, ends[1] - self._origin.y, 0.0)
        patch = self._patch(x, y, on_wall)
        lost = ranges > self._reach.take(patch)
        lost |= self._incidence(x, y, directions) < self._facing.take(patch)
        measured = self._mix(ranges, firsts, rng)
        spread = self._noise.take(patch) + noise
        spread *= 1.0 + np.where(seen, ranges, 0.0) / _NOISE_DOUBLES
        measured += self._offset.take(patch) + spread * rng.standard_normal(len(ranges))
        measured[lost] = np.inf
        return measured

    def glares(self, ends: BeamEnds, on_wall: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Return (n,) which beams meet a surface so that it passes for a reflector."""
        x, y = ends.x - self._origin.x, ends.y - self._origin.y
        incidence = self._incidence(x, y, (ends.c, ends.s))
        return np.asarray(incidence > self._glare.take(self._patch(x, y, on_wall)))

    def _patch(
        self, x: NDArray[np.float64], y: NDArray[np.float64], on_wall: NDArray[np.bool_]
    ) -> NDArray[np.intp]:
        """Return (n,) indices of the surfaces at x, y (n,), m, in the grid's frame."""
        patch = np.floor(y / _STRETCH) * self._columns + np.floor(x / _STRETCH)
        patch = np.where(on_wall, np.maximum(patch, 0.0), self._no_wall)
        return np.asarray(np.minimum(patch, self._no_wall), dtype=np.intp)

    def _incidence(
        self,
        x: NDArray[np.float64],
        y: NDArray[np.float64],
        directions: tuple[NDArray[np.float64], NDArray[np.float64]],
    ) -> NDArray[np.float64]:
        """Return (n,) cosines of the angle between beams and the normals of the faces they hit.

        x, y (n,): ends in the grid's frame, m. A beam ends on the side of a cell.
        """
        across, up = x / self._resolution, y / self._resolution
        on_side = np.abs(across - np.rint(across)) < np.abs(up - np.rint(up))
        return np.asarray(np.abs(np.where(on_side, *directions)))

    def _mix(
        self, ranges: NDArray[np.float64], firsts: Sequence[int], rng: np.random.Generator
    ) -> NDArray[np.float64]:
        """Return ranges of which some at edges lie between the near and the far side."""
        with np.errstate(invalid="ignore"):
            step = ranges[1:] - ranges[:-1]
            size = np.abs(step)
            # Along a wall seen at a grazing angle the steps on both sides are as large.
            beside = np.fmin(size[2:], size[:-2])
            size[1:-1][size[1:-1] < _STANDS_OUT * beside] = 0.0
            edges = np.flatnonzero((size > _JUMP) & (size < np.inf))
        mixed = ranges.copy()
        chance, share = rng.random((2, len(edges)))
        struck = (chance < self._mixed) & ~np.isin(edges + 1, firsts)
        edges, share = edges[struck], share[struck]
        far = edges + (step[edges] > 0.0)
        mixed[far] = ranges[far] - share * size[edges]
        return mixed

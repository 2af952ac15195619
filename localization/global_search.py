"""Particles over the whole map: for a start at an unknown pose, and to be found again."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from localization.filter import ParticleFilter
from localization.settings import GlobalSettings, SampleSettings
from maps.occupancy_map import FREE, MapError, OccupancyMap


class GlobalSearch:
    """The free floor clear of walls: where the robot may stand if nothing is known."""

    def __init__(self, settings: GlobalSettings, occupancy: OccupancyMap) -> None:
        self._settings = settings
        self._occupancy = occupancy
        standable = (occupancy.cells == FREE) & (occupancy.distance_field() >= settings.clearance)
        # One bit a cell: searches are rare, large maps are not.
        self._standable = np.packbits(standable)
        self._count = int(np.count_nonzero(standable))

    @property
    def possible(self) -> bool:
        """Whether there is such floor on the map."""
        return self._count > 0

    def sample(self, rng: np.random.Generator) -> NDArray[np.float64]:
        """Return particles (n, 3) (map_from_base) uniform over floor and headings.

        Raises MapError on a map without such floor.
        """
        if not self.possible:
            raise MapError("the map has no free floor clear of walls to search for the robot on")
        resolution, origin = self._occupancy.resolution, self._occupancy.origin
        wanted = math.ceil(self._count * resolution**2 * self._settings.particles_per_area)
        count = min(wanted, self._settings.maximum)
        floor = np.flatnonzero(np.unpackbits(self._standable, count=self._occupancy.cells.size))
        rows, cols = np.divmod(
            floor[rng.integers(self._count, size=count)], self._occupancy.cells.shape[1]
        )
        inside = rng.random((2, count))
        return np.column_stack(
            (
                origin.x + (cols + inside[0]) * resolution,
                origin.y + (rows + inside[1]) * resolution,
                rng.uniform(-math.pi, math.pi, count),
            )
        )

    def weigh_first(
        self, particles: ParticleFilter, points: NDArray[np.float64], samples: SampleSettings
    ) -> None:
        """Weigh a fresh sample by its first scan, end points (m, 2) in base_link, in two looks.

        The sample is so thin that the particle nearest to the robot may see the scan badly. So
        those that see it not too badly are scattered over the gaps between them, and look again.
        """
        search = self._settings
        for look in range(2):
            if look > 0:
                particles.resample(samples)
                particles.scatter(search.closer_xy, search.closer_theta)
            particles.weigh(points, search.independent_beams, search.min_effective)

    def weigh(
        self, particles: ParticleFilter, points: NDArray[np.float64], information: float = 1.0
    ) -> None:
        """Weigh particles by a further scan, so that no place is given up on it alone."""
        search = self._settings
        beams = information * search.independent_beams
        hidden = beams * search.hidden_log_likelihood
        particles.weigh(points, beams, search.min_effective, hidden)

"""Global localization: particles over the whole map, for an unknown start and relocalization."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from localization.cell_table import DISTANCE_BITS, DISTANCE_MASK, cell_table, distance_code
from localization.filter import ParticleFilter
from localization.kld import SampleLimits
from maps.occupancy_map import FREE, MapError, OccupancyMap

PARTICLES_PER_AREA = 300.0  # 1/m^2 of free floor
MAX_PARTICLES = 200_000  # of a fresh sample
CLOSER_XY = 0.1  # m; scatter round particles that fit, for the second pass: half their spacing
CLOSER_THETA = 0.09  # rad; likewise
INDEPENDENT_BEAMS = 6.0  # of a scan: so few that one scan rules out no place
MIN_EFFECTIVE = 0.05  # minimum share of the particles that one scan leaves effective
HIDDEN_LOG_LIKELIHOOD = -1.0  # per beam; lower bound for a scan that fits too badly to decide
CLEARANCE = 0.2  # m between a particle and a wall
_BYTES = np.unpackbits(np.arange(256, dtype=np.uint8)[:, np.newaxis], axis=1)
_BITS_IN_BYTE = _BYTES.sum(axis=1, dtype=np.uint8)
_PLACE_OF_BIT = np.argsort(1 - _BYTES.astype(np.int8), axis=1, kind="stable")


class GlobalSearch:
    """Samples poses on the free floor clear of walls, and weights them with low information."""

    def __init__(self, occupancy: OccupancyMap) -> None:
        self._table = cell_table(occupancy)
        inner = self._table.codes[1:-1, 1:-1]
        clear = distance_code(CLEARANCE) | FREE << DISTANCE_BITS
        standable = (inner >= clear) & (inner <= DISTANCE_MASK | FREE << DISTANCE_BITS)
        # One bit per cell saves memory on large maps.
        self._standable = np.packbits(standable, axis=1)
        self._count = int(np.count_nonzero(standable))

    @property
    def possible(self) -> bool:
        """Whether there is free floor clear of walls on the map."""
        return self._count > 0

    def sample(self, rng: np.random.Generator) -> NDArray[np.float64]:
        """Return particles (n, 3) (map_from_base) uniform over floor and headings.

        Raises MapError on a map without such floor.
        """
        if not self.possible:
            raise MapError("the map has no free floor clear of walls to search for the robot on")
        resolution, corner = self._table.resolution, self._table.corner
        wanted = math.ceil(self._count * resolution**2 * PARTICLES_PER_AREA)
        count = min(wanted, MAX_PARTICLES)
        rows, cols = self._cells(np.sort(rng.integers(self._count, size=count)))
        inside = rng.random((2, count))
        return np.column_stack(
            (
                corner.real + (cols + 1 + inside[0]) * resolution,
                corner.imag + (rows + 1 + inside[1]) * resolution,
                rng.uniform(-math.pi, math.pi, count),
            )
        )

    def _cells(self, numbers: NDArray[np.int64]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Return (rows, cols), (n,) each, of standable cells by their sorted numbers (n,)."""
        in_byte = _BITS_IN_BYTE.take(self._standable.ravel())
        up_to = np.cumsum(in_byte, dtype=np.int32)
        byte = np.searchsorted(up_to, numbers, side="right")
        bit = numbers - (up_to[byte] - in_byte[byte])
        rows, byte_of_row = np.divmod(byte, self._standable.shape[1])
        return rows, 8 * byte_of_row + _PLACE_OF_BIT[self._standable.ravel()[byte], bit]

    def weigh_first(
        self, particles: ParticleFilter, points: NDArray[np.float64], limits: SampleLimits
    ) -> None:
        """Weight a fresh sample by its first scan, end points (m, 2) in base_link, in two passes.

        The sample is so sparse that even the particle nearest to the true pose may fit badly. So
        the better ones are resampled, scattered over the gaps between them and weighted again.
        limits: of the number of particles then.
        """
        for again in (False, True):
            if again:
                particles.resample(limits)
                particles.scatter(CLOSER_XY, CLOSER_THETA)
            particles.weigh(points, INDEPENDENT_BEAMS, MIN_EFFECTIVE)

    def weigh(
        self, particles: ParticleFilter, points: NDArray[np.float64], information: float = 1.0
    ) -> None:
        """Weight particles by a further scan, (m, 2), so that it alone rules out no place.

        information: of the scan, 0 to 1.
        """
        beams = information * INDEPENDENT_BEAMS
        hidden = beams * HIDDEN_LOG_LIKELIHOOD
        particles.weigh(points, beams, MIN_EFFECTIVE, hidden)

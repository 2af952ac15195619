"""What the sonars of the simulated world make of the rays over their cones."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tools.simulation.truth.surroundings_truth import SonarTruth

_FLAT = 0.26
"""rad between the slopes left and right of the axis up to which a surface is flat; ours."""
_NEAREST = 0.15  # m; the first centimetres are deaf while the transducer rings out


class SonarEcho:
    """Converts ranges over the cones of transducers to readings."""

    def __init__(self, truth: SonarTruth, rng: np.random.Generator) -> None:
        self._truth = truth
        self._rng = rng
        self.cone = np.linspace(-truth.half_cone, truth.half_cone, truth.rays)
        """Directions of the rays off the axis (k,), rad."""

    def heard(self, rays: NDArray[np.float64], ring: int, farthest: float) -> NDArray[np.float64]:
        """Return readings (n,), m, from ranges (n, k) over the cones; farthest without an echo.

        ring: number of transducers of each robot, of which n is a multiple.
        """
        truth = self._truth
        echoes: NDArray[np.float64] = np.minimum(rays.min(axis=1), farthest)
        if truth.mirrors:
            echoes[self._is_mirror(rays)] = farthest
        if not (truth.false_echoes or truth.crosstalk):
            return echoes
        chance, place = self._rng.random((2, len(echoes)))
        false = chance < truth.false_echoes
        crossed = ~false & (chance < truth.false_echoes + truth.crosstalk)
        neighbour = np.roll(echoes.reshape(-1, ring), 1, axis=1).ravel()
        echoes = np.where(crossed, np.minimum(echoes, neighbour), echoes)
        return np.asarray(np.where(false, _NEAREST + place * (echoes - _NEAREST), echoes))

    def _is_mirror(self, rays: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return (n,) which cones end on a flat surface that sends nothing back."""
        middle = len(self.cone) // 2
        step = self.cone[middle + 1] - self.cone[middle]
        c, s = np.cos(step), np.sin(step)
        axis = np.minimum(rays[:, middle], 1e3)
        right, left = (np.minimum(rays[:, middle + side], 1e3) for side in (-1, 1))
        # Slope of the surface against the perpendicular to the axis, on either side of it.
        on_left = np.arctan2(left * c - axis, left * s)
        on_right = np.arctan2(axis - right * c, right * s)
        slope = np.minimum(np.abs(on_left), np.abs(on_right))
        flat = np.abs(on_left - on_right) < _FLAT
        steep = flat & (slope > self._truth.critical)
        return np.asarray(steep & (self._rng.random(len(rays)) < self._truth.mirrors))

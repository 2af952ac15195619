"""The floor of the simulated world where it is not flat: doorsills and slopes on the border."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from maps.border import Border
from maps.occupancy_map import OccupancyMap
from maps.pose import Pose
from tools.simulation.grid_rectangle import cells_in
from tools.simulation.truth.surroundings_truth import FloorTruth

_SILL = (0.10, 1.6)  # m along and across the border; ours
_SLOPE = (2.0, 1.6)  # m, likewise; ours
_SHIFT = 0.25  # share of the distance between two patches that the seed shifts them by


class Patch(NamedTuple):
    """A part of the floor. pitch: rad, nose down for a robot that heads along direction, rad."""

    pitch: float
    direction: float
    is_sill: bool


class UnevenFloor:
    """Patches of a floor; number 0 is the flat rest."""

    def __init__(
        self, occupancy: OccupancyMap, border: Border, truth: FloorTruth, rng: np.random.Generator
    ) -> None:
        """Draw the places of sills and slopes, about evenly spaced."""
        self.truth = truth
        self._occupancy = occupancy
        self._numbers: NDArray[np.int16] = np.zeros(occupancy.cells.shape, dtype=np.int16)
        self._patches = [Patch(0.0, 0.0, is_sill=False)]
        sills = [True] * truth.sills + [False] * truth.slopes
        for number, is_sill in enumerate(rng.permutation(sills).tolist()):
            place = (number + float(rng.uniform(-_SHIFT, _SHIFT))) / len(sills)
            point = border.at(place * border.length)
            direction = math.atan2(point.ty, point.tx)
            pitch = (truth.sill_pitch if is_sill else truth.slope) * float(rng.choice((-1.0, 1.0)))
            length, width = _SILL if is_sill else _SLOPE
            middle = Pose(point.x, point.y, direction)
            rows, cols = cells_in(occupancy, middle, length / 2, width / 2)
            self._numbers[rows, cols] = len(self._patches)
            self._patches.append(Patch(pitch, direction, is_sill))

    def number_at(self, pose: Pose) -> int:
        """Return the number of the patch under a pose."""
        occupancy = self._occupancy
        row = math.floor((pose.y - occupancy.origin.y) / occupancy.resolution)
        col = math.floor((pose.x - occupancy.origin.x) / occupancy.resolution)
        rows, cols = self._numbers.shape
        return int(self._numbers[row, col]) if 0 <= row < rows and 0 <= col < cols else 0

    def is_sill(self, number: int) -> bool:
        """Return whether a patch is a doorsill."""
        return self._patches[number].is_sill

    def pitch(self, number: int, theta: float) -> float:
        """Return by how much the nose of a robot with heading theta, rad, is down there, rad."""
        patch = self._patches[number]
        return patch.pitch * math.cos(theta - patch.direction) if patch.pitch else 0.0

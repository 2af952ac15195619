"""How well one scan agrees with the map at one pose: the evidence that health is judged by.

Three questions: do the beams end on mapped surfaces; which end short of one, on a person or a
teammate; and how many pass through mapped walls, which the likelihood field does not ask.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from localization.distance_surface import DistanceSurface
from localization.likelihood_field import spread_evenly
from localization.refinement import TOO_FEW_POINTS, as_complex, turned
from maps.occupancy_map import FREE, OCCUPIED, UNKNOWN, OccupancyMap
from maps.pose import Pose

MAX_POINTS = 180  # of a scan, spread evenly over it
SIGMA = 0.1  # m; an end point this far from the map fits by 61 %
DYNAMIC_DISTANCE = 0.3  # m; an end point on free floor, farther than this from the map, is dynamic
MAX_DYNAMIC = 0.3  # share of the beams: as many are assumed to end on people, at most
HIDING_REACH = 1.5  # m; something that hides more than MAX_DYNAMIC is nearer
MIN_FIT_BESIDE = 0.85  # fit of what is seen beside it, for the pose to be trusted
RAYS = 45  # beams followed through the map, at most
REACH = 10.0  # m; how far they are followed
MARGIN = 0.3  # m before the end of a beam within which it may touch a wall


@dataclass(frozen=True, slots=True)
class Fit:
    """How well end points fit the map: mean of exp(-d^2 / 2 sigma^2), 1 if all are on surfaces."""

    whole: float
    """Of all end points."""
    fit_without_dynamic: float
    """Without dynamic end points: those on free floor, up to MAX_DYNAMIC of all."""


class ScanCheck:
    """Checks scans against one map."""

    def __init__(self, occupancy: OccupancyMap, surface: DistanceSurface) -> None:
        self._surface = surface
        self._padded = np.pad(occupancy.cells, 1, constant_values=UNKNOWN)  # what lies outside
        self._scale = 1.0 / occupancy.resolution
        self._origin = complex(occupancy.origin.x, occupancy.origin.y)
        # Half a cell apart, so that no wall of one cell is stepped over.
        self._steps = np.arange(0.5, 2.0 * REACH * self._scale) * 0.5
        self._half = np.float32(-0.5 / SIGMA**2)

    def fit(self, pose: Pose, points: NDArray[np.float64]) -> Fit | None:
        """Return how well end points (m, 2) fit the map at a pose; None: too few to tell."""
        ends = as_complex(spread_evenly(points, MAX_POINTS))
        if len(ends) < TOO_FEW_POINTS:
            return None
        arms = turned(ends, pose)
        distance = self._surface.sample(pose, arms)[2]
        total = float(np.exp(distance * distance * self._half).sum())
        short = distance > DYNAMIC_DISTANCE
        on_floor = int(np.count_nonzero(self._states(pose, arms[short]) == FREE))
        dynamic = min(on_floor, int(MAX_DYNAMIC * len(ends)))
        return Fit(total / len(ends), total / (len(ends) - dynamic))

    def hiding(self, pose: Pose, points: NDArray[np.float64]) -> NDArray[np.bool_] | None:
        """Return (m,) which end points lie on something unmapped that hides much of the map.

        points (m, 2), base_link, m. None if there is no such thing: it stands close before the
        robot, on free floor, and what is seen beside it fits the map at the pose.
        """
        near = np.einsum("ij,ij->i", points, points) < HIDING_REACH**2
        least = MAX_DYNAMIC * len(points)  # fewer do no harm
        if np.count_nonzero(near) <= least:
            return None
        arms = turned(as_complex(points), pose)
        distance = self._surface.sample(pose, arms)[2]
        hiding = near & (distance > DYNAMIC_DISTANCE)
        hiding[hiding] = self._states(pose, arms[hiding]) == FREE
        beside = distance[~hiding]
        if len(points) - len(beside) <= least or len(beside) < TOO_FEW_POINTS:
            return None
        fit = float(np.exp(beside * beside * self._half).mean())
        return hiding if fit >= MIN_FIT_BESIDE else None

    def wall_crossing(self, pose: Pose, points: NDArray[np.float64]) -> float:
        """Return the share of the beams to end points (m, 2) that pass through mapped walls."""
        ends = as_complex(spread_evenly(points, RAYS))
        if len(ends) < TOO_FEW_POINTS:
            return 0.0
        arms = turned(ends, pose) * np.float32(self._scale)
        length = np.abs(arms)
        directions = arms / np.maximum(length, 1e-6)
        places = directions[:, np.newaxis] * self._steps.astype(np.float32)
        before_end = self._steps < (length - MARGIN * self._scale)[:, np.newaxis]
        walls = self._states(pose, places * np.float32(1.0 / self._scale)) == OCCUPIED
        return float((walls & before_end).any(axis=1).mean())

    def _states(self, pose: Pose, arms: NDArray[np.complex64]) -> NDArray[np.uint8]:
        """Return the states of the cells at places given as in ``DistanceSurface.sample``."""
        pixels = (arms + np.complex64(complex(pose.x, pose.y) - self._origin)) * np.float32(
            self._scale
        )
        rows, cols = np.floor(pixels.imag).astype(np.intp), np.floor(pixels.real).astype(np.intp)
        height, width = self._padded.shape
        rows = np.minimum(np.maximum(rows + 1, 0), height - 1)
        cols = np.minimum(np.maximum(cols + 1, 0), width - 1)
        return np.asarray(self._padded.take(rows * width + cols))

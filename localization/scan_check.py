"""Consistency of one scan with the map at one pose: the evidence for the health.

Three checks: the fit of the end points to mapped surfaces; which of them lie before one, on a
person or a teammate; and the share of beams that cross mapped walls, which the likelihood field
does not model.
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
SIGMA = 0.1  # m; an end point at this distance from the map has a fit of 61 %
DYNAMIC_DISTANCE = 0.3  # m; an end point on free floor, farther than this from the map, is dynamic
MAX_DYNAMIC = 0.3  # maximum share of the beams assumed to end on people
HIDING_REACH = 1.5  # m; an object that occludes more than MAX_DYNAMIC is nearer
MIN_FIT_BESIDE = 0.85  # fit of the remaining beams required to trust the pose
RAYS = 45  # beams traced through the map, at most
REACH = 10.0  # m; distance over which they are traced
MARGIN = 0.3  # m before the end of a beam within which it may cross a wall


@dataclass(frozen=True, slots=True)
class Fit:
    """Fit of end points to the map: mean of exp(-d^2 / 2 sigma^2), 1 if all are on surfaces."""

    whole: float
    """Of all end points."""
    fit_without_dynamic: float
    """Without dynamic end points: those on free floor, up to MAX_DYNAMIC of all."""


class ScanCheck:
    """Checks scans against one map."""

    def __init__(self, occupancy: OccupancyMap, surface: DistanceSurface) -> None:
        self._surface = surface
        self._padded = np.pad(occupancy.cells, 1, constant_values=UNKNOWN)  # outside the map
        self._scale = 1.0 / occupancy.resolution
        self._origin = complex(occupancy.origin.x, occupancy.origin.y)
        # Half a cell apart, so that no wall of one cell is stepped over.
        self._steps = np.arange(0.5, 2.0 * REACH * self._scale) * 0.5
        self._half = np.float32(-0.5 / SIGMA**2)

    def fit(self, pose: Pose, points: NDArray[np.float64]) -> Fit | None:
        """Return the fit of end points (m, 2), m, base_link, at a pose; None for too few."""
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
        """Return (m,) which end points lie on an unmapped object that occludes much of the map.

        points (m, 2), base_link, m. Such an object is close to the robot, on free floor, and the
        rest of the scan fits the map at the pose; None if there is none.
        """
        near = np.einsum("ij,ij->i", points, points) < HIDING_REACH**2
        tolerated = MAX_DYNAMIC * len(points)
        if np.count_nonzero(near) <= tolerated:
            return None
        arms = turned(as_complex(points), pose)
        distance = self._surface.sample(pose, arms)[2]
        hiding = near & (distance > DYNAMIC_DISTANCE)
        hiding[hiding] = self._states(pose, arms[hiding]) == FREE
        beside = distance[~hiding]
        if len(points) - len(beside) <= tolerated or len(beside) < TOO_FEW_POINTS:
            return None
        fit = float(np.exp(beside * beside * self._half).mean())
        return hiding if fit >= MIN_FIT_BESIDE else None

    def wall_crossing(self, pose: Pose, points: NDArray[np.float64]) -> float:
        """Return the share of the beams to end points (m, 2) that cross mapped walls, 0..1.

        0 for too few end points.
        """
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
        """Return the cells' states at positions given as in ``DistanceSurface.sample``."""
        pixels = (arms + np.complex64(complex(pose.x, pose.y) - self._origin)) * np.float32(
            self._scale
        )
        rows, cols = np.floor(pixels.imag).astype(np.intp), np.floor(pixels.real).astype(np.intp)
        height, width = self._padded.shape
        rows = np.minimum(np.maximum(rows + 1, 0), height - 1)
        cols = np.minimum(np.maximum(cols + 1, 0), width - 1)
        return np.asarray(self._padded.take(rows * width + cols))

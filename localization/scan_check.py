"""Consistency of one scan with the map at one pose: the evidence for the health.

Three checks: the fit of the end points to mapped surfaces; which of them lie before one, on a
person or a teammate; and the share of beams that cross mapped walls, which the likelihood field
does not model.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from localization.cell_table import DISTANCE_BITS, cell_table
from localization.distance_surface import DistanceSurface
from localization.likelihood_field import RANDOM_SHARE, THROUGH_SHARE, spread_evenly
from localization.refinement import TOO_FEW_POINTS, as_complex, turned
from maps.occupancy_map import FREE, OCCUPIED, UNKNOWN, OccupancyMap
from maps.pose import Pose

MAX_POINTS = 180  # of a scan, spread evenly over it
SIGMA = 0.1  # m; an end point at this distance from the map has a fit of 61 %
DYNAMIC_DISTANCE = 0.3  # m; an end point on free floor, farther than this from the map, is dynamic
MAX_DYNAMIC = 0.3  # maximum share of the beams assumed to end on people
MAX_UNMAPPED = (
    0.5  # maximum share of the beams that say nothing as they end where nothing is mapped
)
HIDING_REACH = 1.5  # m; an object that occludes more than MAX_DYNAMIC is nearer
CROWD_REACH = 3.0  # m; likewise for a crowd, and for the fit alone
MIN_BESIDE = 0.25  # minimum share of the beams that must be seen beside a crowd
MIN_FIT_BESIDE = 0.85  # fit of the remaining beams required to trust the pose
RAYS = 45  # beams traced through the map for the health, at most
REACH = 10.0  # m; distance over which they are traced
FAR_REACH = 20.0  # m; likewise, for beams that end on free floor
MARGIN = 0.3  # m before the end of a beam within which it may cross a wall


@dataclass(frozen=True, slots=True)
class Fit:
    """Fit of end points to the map: mean of exp(-d^2 / 2 sigma^2), 1 if all are on surfaces."""

    whole: float
    """Of all end points but those where nothing is mapped, up to MAX_UNMAPPED of all."""
    fit_without_dynamic: float
    """Also without dynamic end points: those on free floor, up to MAX_DYNAMIC of all; of a crowd,
    nearer than CROWD_REACH, any number if those beside it fit."""
    beside: float
    """Without any end point on free floor, as on people. 1 if none are left."""
    through: float
    """Of the beams that end behind mapped walls or on them, the share behind: people, even such as
    stand close to walls, cannot explain it."""


class ScanCheck:
    """Checks scans against one map."""

    def __init__(self, occupancy: OccupancyMap, surface: DistanceSurface) -> None:
        self._surface = surface
        table = cell_table(occupancy)
        self._codes, self._corner = table.codes, table.corner
        self._scale = 1.0 / table.resolution
        # Half a cell apart, so that no wall of one cell is stepped over.
        self._steps = np.arange(0.25, FAR_REACH * self._scale, 0.5, dtype=np.float32)
        self._steps *= np.float32(occupancy.resolution)
        self._half = np.float32(-0.5 / SIGMA**2)

    def fit(self, pose: Pose, points: NDArray[np.float64]) -> Fit | None:
        """Return the fit of end points (m, 2), m, base_link, at a pose; None for too few."""
        ends = as_complex(spread_evenly(points, MAX_POINTS))
        if len(ends) < TOO_FEW_POINTS:
            return None
        arms = turned(ends, pose)
        distance = self._surface.sample(pose, arms)[2]
        fits = np.exp(distance * distance * self._half)
        off = np.flatnonzero(np.abs(distance) > DYNAMIC_DISTANCE)
        states = self._states(pose, arms[off])
        inside = len(off)
        off, states = off[states != OCCUPIED], states[states != OCCUPIED]
        inside -= len(off)
        # What ends behind a mapped wall is wrong, whatever lies there.
        open_way = ~self._crossing(pose, arms[off])
        on_floor, unmapped = off[open_way & (states == FREE)], off[open_way & (states == UNKNOWN)]
        behind = inside + int(np.count_nonzero(~open_way))
        count, total = len(ends), float(fits.sum())
        left = count - min(len(unmapped), int(MAX_UNMAPPED * count))
        elsewhere = np.ones(count, dtype=np.bool_)
        elsewhere[on_floor] = elsewhere[unmapped] = False
        seen = int(np.count_nonzero(elsewhere))
        beside = float(fits[elsewhere].mean()) if seen >= TOO_FEW_POINTS else 1.0
        dynamic = min(len(on_floor), int(MAX_DYNAMIC * count))
        if seen >= max(TOO_FEW_POINTS, MIN_BESIDE * count) and beside >= MIN_FIT_BESIDE:
            near = int(np.count_nonzero(np.abs(ends[on_floor]) < CROWD_REACH))
            dynamic = min(len(on_floor), max(dynamic, near))
        return Fit(
            total / left,
            total / max(left - dynamic, seen, 1),
            beside,
            behind / max(behind + total, 1e-9),
        )

    def log_likelihood(self, pose: Pose, points: NDArray[np.float64]) -> float:
        """Return the mean log-likelihood of the beams to points (m, 2), m, base_link, at a pose.

        As of ``LikelihoodField`` with beams through walls. 0 without points.
        """
        arms = turned(as_complex(spread_evenly(points, MAX_POINTS)), pose)
        if len(arms) == 0:
            return 0.0
        distance = self._surface.sample(pose, arms)[2]
        fits = np.exp(distance * distance * self._half)
        likelihood = (1.0 - RANDOM_SHARE) * fits + RANDOM_SHARE
        likelihood[self._crossing(pose, arms)] = THROUGH_SHARE
        return float(np.log(likelihood).mean())

    def log_odds(self, pose: Pose, other: Pose, points: NDArray[np.float64]) -> float:
        """Return by how much ``log_likelihood`` of a scan is greater at a pose than at another."""
        return self.log_likelihood(pose, points) - self.log_likelihood(other, points)

    def short(self, pose: Pose, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return (m,) which end points (m, 2), m, base_link, lie on free floor, as on people.

        Those behind a mapped wall do not.
        """
        arms = turned(as_complex(points), pose)
        short = self._surface.sample(pose, arms)[2] > DYNAMIC_DISTANCE
        short[short] = self._states(pose, arms[short]) == FREE
        short[short] = ~self._crossing(pose, arms[short])
        return short

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
        return float(self._crossing(pose, turned(ends, pose), REACH).mean())

    def _crossing(
        self, pose: Pose, arms: NDArray[np.complex64], reach: float = FAR_REACH
    ) -> NDArray[np.bool_]:
        """Return (m,) which beams, as of ``turned``, cross a mapped wall well before they end.

        reach: m, over which they are traced.
        """
        length = np.abs(arms)
        traced = min(reach, float(length.max(initial=0.0)))
        steps = self._steps[: int(np.searchsorted(self._steps, traced))]
        directions = arms / np.maximum(length, 1e-6)
        places = directions[:, np.newaxis] * steps
        before_end = steps < (length - MARGIN)[:, np.newaxis]
        walls = self._states(pose, places) == OCCUPIED
        return np.asarray((walls & before_end).any(axis=1))

    def _states(self, pose: Pose, arms: NDArray[np.complex64]) -> NDArray[np.uint16]:
        """Return the cells' states at positions given as in ``DistanceSurface.sample``."""
        pixels = (arms + np.complex64(complex(pose.x, pose.y) - self._corner)) * np.float32(
            self._scale
        )
        rows, cols = np.floor(pixels.imag).astype(np.intp), np.floor(pixels.real).astype(np.intp)
        height, width = self._codes.shape
        rows = np.minimum(np.maximum(rows, 0), height - 1)
        cols = np.minimum(np.maximum(cols, 0), width - 1)
        return np.asarray(self._codes.take(rows * width + cols) >> DISTANCE_BITS)

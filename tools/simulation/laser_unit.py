"""One laser as it is built and mounted: what its own view holds, its systematic errors, dazzle."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from maps.pose import Pose
from tools.simulation.raycast import cast_bodies
from tools.simulation.silhouette import middles_of, shapes_of, silhouette_of
from tools.simulation.truth.robot_truth import LaserTruth

_DAZZLED_FOR = (0.3, 2.0)  # s; ours
_DAZZLED_SECTOR = (math.radians(5.0), math.radians(25.0))  # rad; sun or a lamp; ours
_OWN_PARTS_WITHIN = 2.0  # m
_FARTHEST = 32.0  # m, within which the world has returns


class LaserUnit:
    """One laser. ``ends`` limits its rays before, ``reported`` changes its ranges after a scan."""

    def __init__(self, truth: LaserTruth, t: float, rng: np.random.Generator) -> None:
        """Make the laser, switched on at ``t``; rng: of its dazzles alone."""
        self._truth = truth
        self._rng = rng
        self._parts: dict[tuple[int, float], NDArray[np.float64]] = {}
        self._dazzled_until = -math.inf
        self._sector = (0.0, 0.0)
        self._next_dazzle = t + self._pause()
        self._stuck_from = t + truth.stuck_from
        self._stuck_at: NDArray[np.float64] | None = None

    def ends(self, bearings: NDArray[np.float64], pitch: float) -> NDArray[np.float64] | None:
        """Return (n,) ranges, m, at which rays end in any surroundings; None if nowhere.

        bearings (n,): rad from the laser's axis. pitch: rad by which the robot's nose is down.
        """
        own = self._own_parts(bearings) if self._truth.own_parts else None
        down, left = self._truth.tilt + pitch, self._truth.roll
        if not down and not left:
            return own
        with np.errstate(divide="ignore"):
            floor = self._truth.height / (down * np.cos(bearings) + left * np.sin(bearings))
        floor[floor <= 0.0] = np.inf
        return floor if own is None else np.minimum(own, floor)

    def reported(
        self, ranges: NDArray[np.float64], bearings: NDArray[np.float64], t: float
    ) -> NDArray[np.float64]:
        """Return what the laser reports at ``t`` of measured ranges (n,), m; inf for no return."""
        truth = self._truth
        if truth.offset or truth.stretch:
            ranges = np.maximum(ranges * (1.0 + truth.stretch) + truth.offset, 0.0)
        if truth.quantum:
            ranges = np.rint(ranges / truth.quantum) * truth.quantum
        if truth.reach < _FARTHEST:
            ranges = np.where(ranges > truth.reach, np.inf, ranges)
        if t >= self._next_dazzle:
            self._dazzle(t)
        if t < self._dazzled_until:
            low, high = self._sector
            ranges = np.where((bearings > low) & (bearings < high), np.inf, ranges)
        return ranges if t < self._stuck_from else self._stuck(ranges, bearings)

    def _stuck(
        self, ranges: NDArray[np.float64], bearings: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return ranges (n,), m, with those of stuck beams as they were when they stuck."""
        if self._stuck_at is None or len(self._stuck_at) != len(ranges):
            self._stuck_at = ranges
        low, high = self._truth.stuck
        return np.where((bearings > low) & (bearings < high), self._stuck_at, ranges)

    def _own_parts(self, bearings: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return (n,) ranges to the robot's own parts, m; inf beside them."""
        key = len(bearings), float(bearings[0])
        if key not in self._parts:
            parts = [[silhouette_of(corners) for corners in self._truth.own_parts]]
            x, y, theta = self._truth.mount
            middles = middles_of(parts, [Pose(0.0, 0.0, 0.0)])
            self._parts[key] = cast_bodies(
                x, y, theta + bearings, middles, shapes_of(parts), _OWN_PARTS_WITHIN
            )
        return self._parts[key]

    def _dazzle(self, t: float) -> None:
        """Blind a sector for a while."""
        self._next_dazzle = t + self._pause()
        self._dazzled_until = t + float(self._rng.uniform(*_DAZZLED_FOR))
        low = float(self._rng.uniform(-math.pi / 2, math.pi / 2))
        self._sector = low, low + float(self._rng.uniform(*_DAZZLED_SECTOR))

    def _pause(self) -> float:
        """Return the time until the next dazzle, s."""
        rate = self._truth.dazzles
        return float(self._rng.exponential(1.0 / rate)) if rate else math.inf

"""What robots would see with perfect sensors: true places of teammates in view, then remembered.

The field of view is the laser's, 180 degrees ahead; walls and other bodies hide what is behind
them. A teammate out of view is remembered as the tracker does: carried on with a decaying speed.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from maps.occupancy_map import OCCUPIED, OccupancyMap
from robot_agent.perception.settings import PerceptionSettings

_SAMPLES = 48  # along a line of sight; at most 0.09 m apart over the detection range
_HIDING_RADIUS = 0.20  # m; half a Pioneer's width: a line nearer to a body's middle is cut

Array = NDArray[np.float64]


class IdealSight:
    """Who sees whom, and where each robot holds its teammates to be."""

    def __init__(self, settings: PerceptionSettings, occupancy: OccupancyMap, count: int) -> None:
        self._settings = settings
        self._origin = (occupancy.origin.x, occupancy.origin.y)
        self._resolution = occupancy.resolution
        self._walls = np.pad(occupancy.cells == OCCUPIED, 1, constant_values=True)
        spacing = settings.detection_range / (_SAMPLES - 1)
        # Lines are sampled; what is nearer to a wall than half the spacing has one between samples.
        room = np.pad(occupancy.distance_field(), 1) - occupancy.resolution / 2.0
        self._opaque = self._walls | (room < spacing / 2.0)
        self._shares = np.linspace(0.0, 1.0, _SAMPLES)
        self._last_seen = np.full((count, count), -np.inf)
        self._place = np.zeros((2, count, count))
        self._velocity = np.zeros((2, count, count))
        self._in_range = np.zeros((count, count), dtype=np.bool_)
        self._upper = np.triu(np.ones((count, count), dtype=np.bool_), 1)
        self.apart = np.full((count, count), np.inf)
        """Distances (n, n) between base_links, m; infinite on the diagonal."""

    def look(
        self, t: float, base: Array, heading: Array, middle: Array, speed: Array
    ) -> list[tuple[float, float] | None]:
        """Look at t, s; return the place of each robot's closest teammate, or None.

        base, heading, middle: (2, n) base_link in the map, unit vector ahead, centre of the body,
        m. speed: (n,) m/s ahead.
        """
        settings = self._settings
        # 1. Who is in view.
        dx, dy = (middle[axis][None, :] - base[axis][:, None] for axis in (0, 1))
        apart = np.hypot(base[0][None, :] - base[0][:, None], base[1][None, :] - base[1][:, None])
        np.fill_diagonal(apart, np.inf)
        self.apart = apart
        ahead = dx * heading[0][:, None] + dy * heading[1][:, None] > 0.0
        facing = ahead & (apart <= settings.detection_range)
        seen = facing & self._clear(middle, facing | facing.T)
        # 2. What is remembered of the others.
        self._last_seen[seen] = t
        for axis in (0, 1):
            self._place[axis] = np.where(seen, middle[axis], self._place[axis])
            moving = speed * heading[axis]
            self._velocity[axis] = np.where(seen, moving, self._velocity[axis])
        return self._closest(t, base)

    def _closest(self, t: float, base: Array) -> list[tuple[float, float] | None]:
        """Return each robot's closest teammate, in view or remembered, within visibility."""
        settings = self._settings
        age = t - self._last_seen
        known = age <= settings.memory
        if not known.any():
            self._in_range[:] = False
            return [None] * len(base[0])
        decay = settings.velocity_decay
        reach = decay * (1.0 - np.exp(-np.where(known, age, 0.0) / decay))
        place = self._place + reach * self._velocity
        distance = np.hypot(place[0] - base[0][:, None], place[1] - base[1][:, None])
        limit = settings.visibility + settings.visibility_margin * self._in_range
        self._in_range = known & (distance <= limit)
        distance[~self._in_range] = np.inf
        nearest = distance.argmin(axis=1).tolist()
        return [
            (float(place[0, i, j]), float(place[1, i, j])) if self._in_range[i, j] else None
            for i, j in enumerate(nearest)
        ]

    def _clear(self, middle: Array, wanted: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Return (n, n) whether the wanted pairs have no wall and no body between them."""
        clear: NDArray[np.bool_] = np.zeros(wanted.shape, dtype=np.bool_)
        one, other = np.nonzero(wanted & self._upper)
        if not len(one):
            return clear
        start, way = middle[:, one], middle[:, other] - middle[:, one]
        free = ~self._walled(start, way)
        if middle.shape[1] > 2:
            free &= ~_hidden(middle, one, other, start, way)
        clear[one, other] = clear[other, one] = free
        return clear

    def _walled(self, start: Array, way: Array) -> NDArray[np.bool_]:
        """Return (m,) whether a wall lies on the lines from start (2, m) along way (2, m)."""
        cells = []
        for axis in (0, 1):
            line = start[axis][:, None] + way[axis][:, None] * self._shares
            cell = ((line - self._origin[axis]) / self._resolution).astype(np.intp) + 1
            cells.append(np.clip(cell, 0, self._opaque.shape[1 - axis] - 1))
        return np.asarray(self._opaque[cells[1], cells[0]].any(axis=1))


def _hidden(
    middle: Array, one: NDArray[np.intp], other: NDArray[np.intp], start: Array, way: Array
) -> NDArray[np.bool_]:
    """Return (m,) whether a third body lies on the lines between the bodies one and other."""
    count = middle.shape[1]
    length2 = np.maximum((way**2).sum(axis=0), 1e-12)[:, None]
    x, y = (middle[axis][None, :] - start[axis][:, None] for axis in (0, 1))
    share = np.clip((x * way[0][:, None] + y * way[1][:, None]) / length2, 0.0, 1.0)
    off = np.hypot(x - share * way[0][:, None], y - share * way[1][:, None])
    bodies = np.arange(count)
    third = (bodies != one[:, None]) & (bodies != other[:, None])
    return np.asarray((third & (off < _HIDING_RADIUS)).any(axis=1))

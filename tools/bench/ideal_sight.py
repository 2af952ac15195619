"""Ideal perception of teammates: true positions while in view, predicted tracks afterwards.

The field of view is the laser's; walls and other bodies occlude. A teammate out of view is
predicted as by the tracker, with a decaying velocity.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from maps.occupancy_map import OCCUPIED, OccupancyMap
from robot_agent.perception.track import TRACK_MEMORY
from robot_agent.perception.track_filter import VELOCITY_DECAY
from robot_agent.perception.visibility import VISIBILITY, VISIBILITY_MARGIN

_SAMPLES = 32  # along a line of sight; at most 0.13 m apart over the detection range
_OCCLUSION_RADIUS = 0.20  # m; half a Pioneer's width: a line nearer to a body's centre is occluded

Array = NDArray[np.float64]


class IdealSight:
    """The teammates in view of each robot, and their positions known to it."""

    def __init__(
        self,
        detection_range: float,
        occupancy: OccupancyMap,
        count: int,
        field_of_view_deg: float = 180.0,
    ) -> None:
        """Prepare a map for ``count`` robots with a detection range, m, and a field of view."""
        self._least_ahead = round(math.cos(math.radians(field_of_view_deg / 2)), 12)
        self._detection_range = detection_range
        self._origin = np.array((occupancy.origin.x, occupancy.origin.y))[:, None]
        self._resolution = occupancy.resolution
        walls = np.pad(occupancy.cells == OCCUPIED, 1, constant_values=True)
        spacing = detection_range / (_SAMPLES - 1)
        # Lines are sampled: a wall nearer than half the spacing may lie between two samples.
        room = np.pad(occupancy.distance_field(), 1) - occupancy.resolution / 2.0
        opaque = walls | (room < spacing / 2.0)
        self._opaque, self._columns = opaque.ravel(), opaque.shape[1]
        self._last_cell = np.array(opaque.shape[::-1])[:, None, None] - 1.0
        self._shares = np.linspace(0.0, 1.0, _SAMPLES)
        self._last_seen = np.full((count, count), -np.inf)
        self._place = np.zeros((2, count, count))
        self._velocity = np.zeros((2, count, count))
        self._in_range = np.zeros((count, count), dtype=np.bool_)
        self._to_itself = np.diag(np.full(count, np.inf))
        self.apart = np.full((count, count), np.inf)
        """Distances (n, n) between base_links, m; infinite on the diagonal."""

    def look(
        self, t: float, base: Array, heading: Array, middle: Array, speed: Array
    ) -> list[tuple[float, float] | None]:
        """Update at t; return each robot's closest teammate's position, m, map frame, or None.

        base, heading, middle: (2, n) base_link in the map, unit vector ahead, centre of the body,
        m. speed: (n,) m/s ahead.
        """
        # 1. Find the pairs in view.
        between = base[:, None, :] - base[:, :, None]
        self.apart = apart = np.sqrt(between[0] ** 2 + between[1] ** 2) + self._to_itself
        one, other = (apart <= self._detection_range).nonzero()
        if len(one):
            along = (middle[:, other] - base[:, one]) * heading[:, one]
            away = np.hypot(*(middle[:, other] - base[:, one]))
            ahead = along[0] + along[1] > self._least_ahead * away
            one, other = one[ahead], other[ahead]
            clear = self._is_visible(middle, one, other)
            # 2. Store their positions and velocities.
            one, other = one[clear], other[clear]
            self._last_seen[one, other] = t
            self._place[:, one, other] = middle[:, other]
            self._velocity[:, one, other] = speed[other] * heading[:, other]
        return self._closest(t, base)

    def _closest(self, t: float, base: Array) -> list[tuple[float, float] | None]:
        """Return each robot's closest teammate, in view or predicted, within the visibility."""
        closest: list[tuple[float, float] | None] = [None] * base.shape[1]
        one, other = (self._last_seen >= t - TRACK_MEMORY).nonzero()
        unseen = self._last_seen[one, other] - t
        reach = VELOCITY_DECAY * (1.0 - np.exp(unseen / VELOCITY_DECAY))
        place = self._place[:, one, other] + reach * self._velocity[:, one, other]
        away = place - base[:, one]
        distance = np.sqrt(away[0] ** 2 + away[1] ** 2)
        limit = VISIBILITY + VISIBILITY_MARGIN * self._in_range[one, other]
        within = distance <= limit
        self._in_range[:] = False
        self._in_range[one[within], other[within]] = True
        nearest: dict[int, float] = {}
        for i, d, x, y in zip(
            one[within].tolist(),
            distance[within].tolist(),
            *place[:, within].tolist(),
            strict=True,
        ):
            if d < nearest.get(i, np.inf):
                nearest[i], closest[i] = d, (x, y)
        return closest

    def _is_visible(
        self, middle: Array, one: NDArray[np.intp], other: NDArray[np.intp]
    ) -> NDArray[np.bool_]:
        """Return (m,) whether no wall and no third body lies between the bodies of each pair."""
        start, way = middle[:, one], middle[:, other] - middle[:, one]
        free = ~self._is_behind_wall(start, way)
        if middle.shape[1] > 2:
            free &= ~_is_occluded(middle, one, other, start, way)
        return np.asarray(free)

    def _is_behind_wall(self, start: Array, way: Array) -> NDArray[np.bool_]:
        """Return (m,) whether a wall lies on the lines from start (2, m) along way (2, m)."""
        first, last = ((place - self._origin) / self._resolution for place in (start, start + way))
        cells = first[:, :, None] + (last - first)[:, :, None] * self._shares + 1.0
        col, row = np.minimum(np.maximum(cells, 0.0), self._last_cell).astype(np.intp)
        return np.asarray(self._opaque.take(row * self._columns + col).any(axis=1))


def _is_occluded(
    middle: Array, one: NDArray[np.intp], other: NDArray[np.intp], start: Array, way: Array
) -> NDArray[np.bool_]:
    """Return (m,) whether a third body lies on the lines between the bodies one and other."""
    count = middle.shape[1]
    length2 = np.maximum((way**2).sum(axis=0), 1e-12)[:, None]
    x, y = (middle[axis][None, :] - start[axis][:, None] for axis in (0, 1))
    share = (x * way[0][:, None] + y * way[1][:, None]) / length2
    share = np.minimum(np.maximum(share, 0.0), 1.0)
    off = np.hypot(x - share * way[0][:, None], y - share * way[1][:, None])
    bodies = np.arange(count)
    third = (bodies != one[:, None]) & (bodies != other[:, None])
    return np.asarray((third & (off < _OCCLUSION_RADIUS)).any(axis=1))

"""Ideal perception of teammates: true positions while in view, predicted tracks afterwards.

The field of view is the laser's; walls and other bodies occlude. A teammate out of view is
predicted as by the tracker, with a decaying velocity.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from maps.occupancy_map import OccupancyMap
from robot_agent.perception.track import TRACK_MEMORY
from robot_agent.perception.track_filter import VELOCITY_DECAY
from robot_agent.perception.visibility import VISIBILITY, VISIBILITY_MARGIN
from tools.bench.sight_lines import SightLines, pass_near

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
        self._lines = SightLines(detection_range, occupancy)
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
        free = ~self._lines.are_behind_wall(start, way)
        bodies = np.arange(middle.shape[1])
        if len(bodies) > 2:
            third = (bodies != one[:, None]) & (bodies != other[:, None])
            near = pass_near(start[:, :, None], way[:, :, None], middle[:, None, :])
            free &= ~(third & near).any(axis=1)
        return np.asarray(free)

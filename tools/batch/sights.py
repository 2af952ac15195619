"""``IdealSight`` for many runs at once: the teammates in view of each robot, or remembered."""

from __future__ import annotations

import math

import cv2
import numpy as np

from maps.occupancy_map import OccupancyMap
from robot_agent.perception.track import TRACK_MEMORY
from robot_agent.perception.track_filter import VELOCITY_DECAY
from robot_agent.perception.visibility import VISIBILITY, VISIBILITY_MARGIN
from tools.batch.arrays import Flags, Indices, Reals
from tools.bench.sight_lines import SightLines, pass_near

_PARTS = (0.125, 0.375, 0.625, 0.875)  # middles of the quarters of a line of sight
_CELL_SLACK = 1.5  # cells: half a diagonal each, of a point's cell and of the nearest wall's


class Sights:
    """What the robots of each run see and remember of each other; arrays over runs x pairs."""

    def __init__(
        self,
        detection_range: float,
        occupancy: OccupancyMap,
        runs: int,
        count: int,
        field_of_view_deg: float,
    ) -> None:
        """count: robots of each run. detection_range: m."""
        self._least_ahead = round(math.cos(math.radians(field_of_view_deg / 2)), 12)
        self._detection_range = detection_range
        self._runs, self._count = runs, count
        self._lines = SightLines(detection_range, occupancy)
        clear = (~self._lines.opaque).astype(np.uint8)
        self._clear = cv2.distanceTransform(clear, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
        n = runs * count
        self._last_seen = np.full((n, count), -math.inf)
        self._place_x, self._place_y, self._velocity_x, self._velocity_y = np.zeros((4, n, count))
        self._in_range = np.zeros((n, count), dtype=np.bool_)
        self.apart = np.full((n, count), math.inf)
        """Distances (n, count), m, to the robots of the same run; infinite to itself."""
        self._arrange()

    def look(
        self,
        t: float,
        base: tuple[Reals, Reals],
        heading: tuple[Reals, Reals],
        middle: tuple[Reals, Reals],
        speed: Reals,
    ) -> tuple[Flags, Reals, Reals]:
        """Update at t; return whether a teammate is in range, and where, m, the closest one is.

        base, heading, middle: (x, y) of base_links in the map, of unit vectors ahead, and of the
        bodies' centres, each (n,). speed: (n,) m/s ahead.
        """
        self._measure(base)
        one, other = (self.apart <= self._detection_range).nonzero()
        if one.size:
            target = self._first[one] + other
            dx, dy = middle[0][target] - base[0][one], middle[1][target] - base[1][one]
            along = dx * heading[0][one] + dy * heading[1][one]
            ahead = (along > self._least_ahead * np.hypot(dx, dy)).nonzero()[0]
            one, other, target = one[ahead], other[ahead], target[ahead]
            clear = self._is_visible(middle, one, target)
            one, other, target = one[clear], other[clear], target[clear]
            self._last_seen[one, other] = t
            self._place_x[one, other], self._place_y[one, other] = (
                middle[0][target],
                middle[1][target],
            )
            self._velocity_x[one, other] = speed[target] * heading[0][target]
            self._velocity_y[one, other] = speed[target] * heading[1][target]
        return self._closest(t, base)

    def pick(self, robots: Indices) -> None:
        """Keep the robots of some runs, all of each run, as ``arrays.pick`` does."""
        for name in ("_last_seen", "_place_x", "_place_y", "_velocity_x", "_velocity_y"):
            setattr(self, name, getattr(self, name)[robots])
        self._in_range, self.apart = self._in_range[robots], self.apart[robots]
        self._runs = len(robots) // self._count
        self._arrange()

    def _arrange(self) -> None:
        count = self._count
        self._itself = np.tile(np.diag(np.full(count, math.inf)), (self._runs, 1))
        self._first = np.repeat(np.arange(self._runs) * count, count)  # of each robot's run
        self.closest = self.apart.min(axis=1)
        """Distance (n,), m, of each robot to the closest of its run."""

    def _measure(self, base: tuple[Reals, Reals]) -> None:
        """Update the distances between the robots of each run."""
        shape = self._runs, self._count
        x, y = base[0].reshape(shape), base[1].reshape(shape)
        dx = (x[:, None, :] - x[:, :, None]).reshape(-1, self._count)
        dy = (y[:, None, :] - y[:, :, None]).reshape(-1, self._count)
        dx *= dx
        dy *= dy
        dx += dy
        self.apart = np.sqrt(dx, out=dx)
        self.apart += self._itself
        self.closest = self.apart.min(axis=1)

    def _closest(self, t: float, base: tuple[Reals, Reals]) -> tuple[Flags, Reals, Reals]:
        n = len(base[0])
        mate, mate_x, mate_y = np.zeros(n, dtype=np.bool_), np.zeros(n), np.zeros(n)
        one, other = (self._last_seen >= t - TRACK_MEMORY).nonzero()
        if not one.size:
            self._in_range[:] = False
            return mate, mate_x, mate_y
        reach = VELOCITY_DECAY * (1.0 - np.exp((self._last_seen[one, other] - t) / VELOCITY_DECAY))
        x = self._place_x[one, other] + reach * self._velocity_x[one, other]
        y = self._place_y[one, other] + reach * self._velocity_y[one, other]
        dx, dy = x - base[0][one], y - base[1][one]
        distance = np.sqrt(dx * dx + dy * dy)
        limit = VISIBILITY + VISIBILITY_MARGIN * self._in_range[one, other]
        within = (distance <= limit).nonzero()[0]
        self._in_range[:] = False
        if not within.size:
            return mate, mate_x, mate_y
        one, distance = one[within], distance[within]
        self._in_range[one, other[within]] = True
        # The nearest of each robot, the first of those equally near.
        begins = np.flatnonzero(np.concatenate(([True], one[1:] != one[:-1])))
        least = np.repeat(
            np.minimum.reduceat(distance, begins), np.diff(np.append(begins, len(one)))
        )
        nearest = (distance == least).nonzero()[0][::-1]
        own = one[nearest]
        mate[own] = True
        mate_x[own], mate_y[own] = x[within][nearest], y[within][nearest]
        return mate, mate_x, mate_y

    def _is_visible(self, middle: tuple[Reals, Reals], one: Indices, target: Indices) -> Flags:
        """Return (m,) whether no wall and no third body lies between the bodies of each pair."""
        x, y = middle[0][one], middle[1][one]
        way_x, way_y = middle[0][target] - x, middle[1][target] - y
        free = self._surely_clear(x, y, way_x, way_y)
        unsure = (~free).nonzero()[0]
        if unsure.size:
            start = np.array((x[unsure], y[unsure]))
            way = np.array((way_x[unsure], way_y[unsure]))
            free[unsure] = ~self._lines.are_behind_wall(start, way)
        if self._count > 2:
            self._hide(middle, one, target, free)
        return free

    def _hide(
        self, middle: tuple[Reals, Reals], one: Indices, target: Indices, free: Flags
    ) -> None:
        """Set those pairs not free between whose bodies a third one lies.

        It is nearer to both than they are to each other, as bodies do not overlap.
        """
        length = self.apart[one, target - self._first[one]]
        between = free & (self.closest[one] < length) & (self.closest[target] < length)
        some = between.nonzero()[0]
        if not some.size:
            return
        one, target, length = one[some], target[some], length[some, None]
        pair, third = ((self.apart[one] < length) & (self.apart[target] < length)).nonzero()
        x, y = middle
        third += self._first[one[pair]]
        one, target = one[pair], target[pair]
        start = np.array((x[one], y[one]))
        way = np.array((x[target], y[target])) - start
        hidden = pass_near(start, way, np.array((x[third], y[third])))
        free[some[pair[hidden]]] = False

    def _surely_clear(self, x: Reals, y: Reals, way_x: Reals, way_y: Reals) -> Flags:
        """Return (m,) whether no wall is near lines; False where only samples would tell."""
        eighth = np.hypot(way_x, way_y) / 8.0 / self._lines.resolution + _CELL_SLACK
        clear = np.ones(len(x), dtype=np.bool_)
        for share in _PARTS:
            cells = self._lines.cells(np.array((x + share * way_x, y + share * way_y)))
            clear &= self._clear.take(cells) > eighth
        return clear

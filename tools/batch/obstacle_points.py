"""``IdealObstacles`` for many robots: other bodies and walls as points in each one's base_link."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from maps.border import Border
from maps.clearance import border_clearance
from maps.occupancy_map import OCCUPIED, OccupancyMap
from robot_agent.motion.footprint import Footprint
from robot_agent.motion.gate_limits import GateLimits
from robot_agent.obstacles.teammate_keep_out import CIRCLE, TeammateKeepOut
from tools.batch.arrays import Codes, Flags, Indices, Reals
from tools.batch.situations import PATROLS
from tools.bench.ideal_obstacles import OUTLINE_STEP, SLACK, corners_of
from tools.bench.ideal_robot import STEP_S
from tools.simulation.robot_body import Outline

_BLOCK = 0.25  # m; side of the blocks for which the walls' points are kept
_OUTSIDE = -1.0  # m of room outside the map


@dataclass(slots=True, eq=False)
class ObstaclePoints:
    """Points (m,) at x, y, m, base_link, each of one owner by its place in ``robots``.

    robots: the numbers of those that have any.
    """

    robots: Indices
    owner: Indices
    x: Reals
    y: Reals

    def of(self, some: Indices) -> ObstaclePoints:
        """Return the points of some of the robots, by their places in ``robots``."""
        if len(some) == len(self.robots):
            return self
        place = np.full(len(self.robots), -1)
        place[some] = np.arange(len(some))
        owner = place[self.owner]
        kept = owner >= 0
        return ObstaclePoints(self.robots[some], owner[kept], self.x[kept], self.y[kept])


NO_POINTS = ObstaclePoints(
    np.empty(0, dtype=np.intp), np.empty(0, dtype=np.intp), np.empty(0), np.empty(0)
)


class Obstacles:
    """Provides the gates with the obstacle points within their range, and no others."""

    def __init__(self, limits: GateLimits, occupancy: OccupancyMap, border: Border) -> None:
        self._limits = limits
        outline = Outline()
        self._outline = outline.perimeter(OUTLINE_STEP)
        self._outline_reach = outline.reach
        self._middle = outline.middle
        self._keep_out = TeammateKeepOut(Footprint(limits))
        self._occupancy = occupancy
        self._corners = corners_of(occupancy.cells == OCCUPIED)
        self._room = _room(occupancy)
        self.border_clearance = border_clearance(occupancy, border).minimum
        self._farthest = float(self._range(np.array([limits.max_speed]))[0])
        self._walls: dict[tuple[int, int], Reals] = {}

    def around(
        self,
        poses: tuple[Reals, Reals, Reals, Reals],
        fastest: Reals,
        apart: Reals,
        on_patrol: tuple[Codes, Reals] | None,
    ) -> ObstaclePoints:
        """Return the obstacle points of all robots.

        poses: x, y, cos and sin of theta (n,). fastest: (n,) m/s. apart: (n, robots of a run) m
        to those of the same run. on_patrol: the actions and distances from the border of the last
        decisions; None before the first.
        """
        x, y, c, s = poses
        sight = self._range(fastest)
        near = self._near_walls(on_patrol, len(x)) & ~self.free(x, y, sight)
        close = apart <= (sight + self._outline_reach)[:, None]
        one, other = close.nonzero()
        walled = near.nonzero()[0]
        if not one.size and not walled.size:
            return NO_POINTS
        robots = np.unique(np.concatenate((one, walled)))
        owners, xs, ys = [], [], []
        if one.size:
            run = one // apart.shape[1] * apart.shape[1]
            owner, bx, by = self._bodies(poses, one, run + other)
            owners.append(robots.searchsorted(owner))
            xs.append(bx)
            ys.append(by)
        for robot, px, py in zip(
            walled.tolist(), x[walled].tolist(), y[walled].tolist(), strict=True
        ):
            points = self._wall_points(px, py)
            dx, dy = points[0] - px, points[1] - py
            owners.append(np.full(len(dx), robots.searchsorted(robot)))
            xs.append(dx * c[robot] + dy * s[robot])
            ys.append(dy * c[robot] - dx * s[robot])
        return ObstaclePoints(
            robots, np.concatenate(owners), np.concatenate(xs), np.concatenate(ys)
        )

    def free(self, x: Reals, y: Reals, distance: Reals | float) -> Flags:
        """Return (n,) whether there is no wall within a distance, m, of positions."""
        resolution, origin = self._occupancy.resolution, self._occupancy.origin
        row = np.floor((y - origin.y) / resolution) + 1.0
        col = np.floor((x - origin.x) / resolution) + 1.0
        rows, cols = self._room.shape
        np.clip(row, 0, rows - 1, out=row)
        np.clip(col, 0, cols - 1, out=col)
        room = self._room.take((row * cols + col).astype(np.intp))
        return np.asarray(room > distance)

    def _range(self, fastest: Reals) -> Reals:
        """Return the farthest distances from base_link that the gates' next step considers, m."""
        limits = self._limits
        v = fastest + limits.max_acceleration * STEP_S
        stopping = v * v / (2.0 * limits.braking) + v * limits.reaction_delay
        return np.asarray(stopping + limits.front + limits.rear + limits.half_width)

    def _near_walls(self, on_patrol: tuple[Codes, Reals] | None, n: int) -> Flags:
        if on_patrol is None:
            return np.ones(n, dtype=np.bool_)
        action, distance = on_patrol
        far = distance + self._outline_reach + SLACK > self.border_clearance
        return np.asarray(~PATROLS[action] | far)

    def _bodies(
        self, poses: tuple[Reals, Reals, Reals, Reals], one: Indices, other: Indices
    ) -> tuple[Indices, Reals, Reals]:
        """Return owners, x and y of the outlines and keep-out circles of others near some."""
        x, y, c, s = poses
        dx, dy = x[other] - x[one], y[other] - y[one]
        # Where each other's base_link is, and how it is turned, seen from this one.
        at_x, at_y = dx * c[one] + dy * s[one], dy * c[one] - dx * s[one]
        cos, sin = c[other] * c[one] + s[other] * s[one], s[other] * c[one] - c[other] * s[one]
        px, py = self._outline.T
        outline_x = at_x[:, None] + cos[:, None] * px - sin[:, None] * py
        outline_y = at_y[:, None] + sin[:, None] * px + cos[:, None] * py
        cx, cy = (self._keep_out.radius * CIRCLE).T
        ring_x = (at_x + cos * self._middle)[:, None] + cx
        ring_y = (at_y + sin * self._middle)[:, None] + cy
        kept = self._keep_out.keeps(ring_x, ring_y)
        owner = np.broadcast_to(one[:, None], outline_x.shape)
        ring_owner = np.broadcast_to(one[:, None], ring_x.shape)
        return (
            np.concatenate((owner.ravel(), ring_owner[kept])),
            np.concatenate((outline_x.ravel(), ring_x[kept])),
            np.concatenate((outline_y.ravel(), ring_y[kept])),
        )

    def _wall_points(self, x: float, y: float) -> Reals:
        """Return corners (2, m), m, map frame, of occupied cells; all within the gates' range."""
        block = math.floor(x / _BLOCK), math.floor(y / _BLOCK)
        points = self._walls.get(block)
        if points is None:
            points = self._walls[block] = self._block_points(*block)
        return points

    def _block_points(self, column: int, line: int) -> Reals:
        resolution, origin = self._occupancy.resolution, self._occupancy.origin
        reach = 0.5 * _BLOCK + self._farthest
        middle_x, middle_y = (column + 0.5) * _BLOCK, (line + 0.5) * _BLOCK
        left, top = (
            max(math.floor((middle - reach - first) / resolution), 0)
            for middle, first in ((middle_x, origin.x), (middle_y, origin.y))
        )
        size = math.ceil(2.0 * reach / resolution) + 2
        rows, cols = self._corners[top : top + size, left : left + size].nonzero()
        return np.array(
            (origin.x + (cols + left) * resolution, origin.y + (rows + top) * resolution)
        )


def _room(occupancy: OccupancyMap) -> Reals:
    """Return (rows + 2, cols + 2) the distance, m, from each cell to walls and rim, less slack."""
    field = occupancy.distance_field()
    rows, cols = field.shape
    row, col = np.arange(rows)[:, None], np.arange(cols)[None, :]
    rim = np.minimum(np.minimum(row, rows - 1 - row), np.minimum(col, cols - 1 - col))
    room = np.minimum(field, rim * occupancy.resolution) - 1.5 * occupancy.resolution
    return np.pad(room.astype(np.float64), 1, constant_values=_OUTSIDE)

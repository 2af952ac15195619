"""Walls of the map near the robot, for the directions its laser does not cover.

The laser covers half of all directions and the sonars little of the rest: a robot that has come
through a door and turns there has no measurement of the door frame behind it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from maps.occupancy_map import OCCUPIED, OccupancyMap
from maps.pose import Pose
from robot_agent.motion.footprint import Footprint
from robot_agent.motion.gate_limits import GateLimits

_MARGIN = 0.1  # m beyond the corners' reach in a turn in place
POSITION_ERROR = 0.015  # m, of a localized pose and of the map together; ours


class WallCells(NamedTuple):
    """Occupied cells of a map near the robot.

    cells: flat indices (n,), ascending. places: (n, 2), m, base_link, the nearest point of each.
    """

    cells: NDArray[np.intp]
    places: NDArray[np.float64]


_NO_CELLS = WallCells(np.empty(0, dtype=np.intp), np.empty((0, 2)))


class MapObstacles:
    """Gives the nearest points of a map's occupied cells near the robot."""

    def __init__(self, occupancy: OccupancyMap, gate: GateLimits) -> None:
        self._map = occupancy
        self._walls = occupancy.cells == OCCUPIED
        self._footprint = Footprint(gate)
        self._turn_margin = gate.turn_margin
        self._reach = self._footprint.corner_reach + _MARGIN

    def around(self, pose: Pose, gone: NDArray[np.intp]) -> NDArray[np.float64]:
        """Return points (n, 2), m, in base_link at map_from_base ``pose``.

        gone: flat indices (m,) of cells that are left out, as nothing is there.

        Points inside the footprint are left out: the pose or the map is wrong there. The others
        are nearer by the error of a position, which the gate's turn margin does not allow for; but
        not so near that they would pin a robot that stands beside a wall.
        """
        cells, points = self.within(self._reach, pose)
        if len(gone):
            points = points[~np.isin(cells, gone, assume_unique=True)]
        outside = points[~self._footprint.covers(points)]
        return self._footprint.nearer(outside, POSITION_ERROR, self._turn_margin)

    def within(self, reach: float, pose: Pose) -> WallCells:
        """Return all cells within reach, m, and some beyond; pose: map_from_base."""
        origin, size = self._map.origin, self._map.resolution
        cells = math.ceil(reach / size)
        row = math.floor((pose.y - origin.y) / size)
        col = math.floor((pose.x - origin.x) / size)
        top, left = max(row - cells, 0), max(col - cells, 0)
        window = self._walls[top : max(row + cells + 1, 0), left : max(col + cells + 1, 0)]
        if not window.any():
            return _NO_CELLS  # the usual case
        near = np.add(np.argwhere(window), (top, left))
        off = self._map.centres(near) - pose[:2]
        off -= np.clip(off, -size / 2, size / 2)  # from the cell's centre to its nearest point
        dx, dy = off.T
        c, s = math.cos(pose.theta), math.sin(pose.theta)
        places = np.column_stack((c * dx + s * dy, c * dy - s * dx))
        return WallCells(near[:, 0] * self._walls.shape[1] + near[:, 1], places)

"""What stands near a robot with ideal sensing: bodies of others, and walls off the border."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from maps.occupancy_map import OCCUPIED, OccupancyMap
from maps.pose import Pose
from robot_agent.motion.gate_settings import GateSettings
from robot_agent.patrol.actions import PATROLLING
from robot_agent.turning_room import turning_room
from tools.bench.ideal_robot import IdealRobot
from tools.bench.robot_body import Outline

_NOTHING = np.empty((0, 2))
_OUTLINE_STEP = 0.08  # m between the points of a body
_BESIDE_BORDER = 0.3  # m; nearer the border keeps its 0.45 m from walls: they cannot matter


class IdealObstacles:
    """Gives the safety gate the points it could look at, and no others.

    reach: m between two base_links beyond which no point of a body is within the gate's reach.
    """

    def __init__(self, gate: GateSettings, occupancy: OccupancyMap) -> None:
        stopping = gate.max_speed**2 / (2.0 * gate.braking) + gate.max_speed * gate.reaction_delay
        self._sight = stopping + gate.front + gate.rear + gate.half_width
        outline = Outline()
        self.reach = self._sight + outline.reach
        self._outline = outline.perimeter(_OUTLINE_STEP)
        self._occupancy = occupancy
        self._wall_corners = _corners(occupancy.cells == OCCUPIED)
        self._room = occupancy.distance_field()

    def around(self, robot: IdealRobot, others: Sequence[IdealRobot]) -> NDArray[np.float64]:
        """Return points (n, 2), m, in the robot's base_link; others: those within reach."""
        pose = robot.body.pose
        parts = [_in_map(self._outline, other.body.pose) for other in others]
        if self._off_border(robot) and not self.free(pose, self._sight):
            parts.append(self._wall_points(pose))
        if not parts:
            return _NOTHING
        c, s = math.cos(pose.theta), math.sin(pose.theta)
        into_base = np.array(((c, -s), (s, c)))
        here = np.array((pose.x, pose.y))
        points = np.asarray((np.concatenate(parts) - here) @ into_base)
        if not others:
            return points
        middles = np.array([other.body.rectangle()[:2] for other in others])
        return np.concatenate((points, turning_room((middles - here) @ into_base)))

    def free(self, pose: Pose, distance: float) -> bool:
        """Tell whether there is no wall within a distance, m, of a pose."""
        resolution, origin = self._occupancy.resolution, self._occupancy.origin
        row = math.floor((pose.y - origin.y) / resolution)
        col = math.floor((pose.x - origin.x) / resolution)
        rows, cols = self._room.shape
        if not (0 <= row < rows and 0 <= col < cols):
            return False
        edge = min(row, col, rows - 1 - row, cols - 1 - col) * resolution
        # Half a cell's diagonal for the wall's cell, and for our own.
        room = min(float(self._room[row, col]), edge) - 1.5 * resolution
        return bool(room > distance)

    def _off_border(self, robot: IdealRobot) -> bool:
        decision = robot.decision
        return (
            decision is None
            or decision.action not in PATROLLING
            or decision.distance_from_border > _BESIDE_BORDER
        )

    def _wall_points(self, pose: Pose) -> NDArray[np.float64]:
        """Return the corners (n, 2), map frame, of occupied cells about a pose."""
        resolution, origin = self._occupancy.resolution, self._occupancy.origin
        row = math.floor((pose.y - origin.y) / resolution)
        col = math.floor((pose.x - origin.x) / resolution)
        size = math.ceil(self._sight / resolution)
        top, left = max(row - size, 0), max(col - size, 0)
        rows, cols = np.nonzero(self._wall_corners[top : row + size + 2, left : col + size + 2])
        return np.column_stack(
            (origin.x + (cols + left) * resolution, origin.y + (rows + top) * resolution)
        )


def _corners(walls: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return (rows + 1, cols + 1) which corners of cells belong to a wall (rows, cols)."""
    padded = np.pad(walls, 1)
    return np.asarray(padded[:-1, :-1] | padded[:-1, 1:] | padded[1:, :-1] | padded[1:, 1:])


def _in_map(points: NDArray[np.float64], pose: Pose) -> NDArray[np.float64]:
    c, s = math.cos(pose.theta), math.sin(pose.theta)
    return np.asarray(points @ np.array(((c, s), (-s, c))) + (pose.x, pose.y))

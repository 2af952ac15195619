"""Obstacle points near a robot with ideal sensing: other bodies, and walls off the border."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from maps.border import Border
from maps.clearance import border_clearance
from maps.occupancy_map import OCCUPIED, OccupancyMap
from maps.pose import Pose
from robot_agent.motion.footprint import Footprint
from robot_agent.motion.gate_limits import GateLimits
from robot_agent.obstacles.teammate_keep_out import TeammateKeepOut
from robot_agent.patrol.actions import PATROLLING
from tools.bench.ideal_robot import STEP_S, IdealRobot
from tools.simulation.robot_body import Outline

_NOTHING = np.empty((0, 2))
OUTLINE_STEP = 0.08  # m between the points of a body
SLACK = 0.02  # m added to the circle that a turning robot's corners reach


class IdealObstacles:
    """Provides the safety gate with the obstacle points within its range, and no others."""

    def __init__(self, gate: GateLimits, occupancy: OccupancyMap, border: Border) -> None:
        self._gate = gate
        self._keep_out = TeammateKeepOut(Footprint(gate))
        outline = Outline()
        self._outline = outline.perimeter(OUTLINE_STEP)
        self._outline_reach = outline.reach
        self._occupancy = occupancy
        self._wall_corners = corners_of(occupancy.cells == OCCUPIED)
        self._room = occupancy.distance_field()
        self._border_clearance = border_clearance(occupancy, border).minimum

    def around(
        self,
        robot: IdealRobot,
        apart: NDArray[np.float64],
        closest: float,
        robots: Sequence[IdealRobot],
    ) -> NDArray[np.float64]:
        """Return points (n, 2), m, in the robot's base_link.

        apart (n,): distances, m, to the robots; closest is their minimum.
        """
        pose, sight = robot.body.pose, self._gate_range(robot)
        parts: list[NDArray[np.float64]] = []
        near: list[int] = []
        if closest <= sight + self._outline_reach:
            near = np.flatnonzero(apart <= sight + self._outline_reach).tolist()
            parts = [_in_map(self._outline, robots[other].body.pose) for other in near]
        if self._is_near_wall(robot) and not self.free(pose, sight):
            parts.append(self._wall_points(pose, sight))
        if not parts:
            return _NOTHING
        c, s = math.cos(pose.theta), math.sin(pose.theta)
        into_base = np.array(((c, -s), (s, c)))
        here = np.array((pose.x, pose.y))
        points = np.asarray((np.concatenate(parts) - here) @ into_base)
        if not near:
            return points
        middles = np.array([robots[other].body.rectangle()[:2] for other in near])
        return np.concatenate((points, self._keep_out.around((middles - here) @ into_base)))

    def _gate_range(self, robot: IdealRobot) -> float:
        """Return the farthest distance from base_link that the gate's next step considers, m."""
        gate = self._gate
        v = robot.fastest + gate.max_acceleration * STEP_S
        stopping = v * v / (2.0 * gate.braking) + v * gate.reaction_delay
        return stopping + gate.front + gate.rear + gate.half_width

    def is_clear_of_walls(self, robot: IdealRobot, step: float) -> bool:
        """Whether no wall is within reach of a motion of at most ``step`` m."""
        reach = robot.body.reach + step
        decision = robot.decision
        # The border's clearance and the robot's distance from it give a lower bound first.
        if decision and decision.distance_from_border + step + reach < self._border_clearance:
            return True
        return self.free(robot.body.pose, reach)

    def free(self, pose: Pose, distance: float) -> bool:
        """Whether there is no wall within ``distance`` m of a pose."""
        resolution, origin = self._occupancy.resolution, self._occupancy.origin
        row = math.floor((pose.y - origin.y) / resolution)
        col = math.floor((pose.x - origin.x) / resolution)
        rows, cols = self._room.shape
        if not (0 <= row < rows and 0 <= col < cols):
            return False
        edge = min(row, col, rows - 1 - row, cols - 1 - col) * resolution
        # Half a cell's diagonal for the wall's cell, and for the pose's.
        room = min(float(self._room[row, col]), edge) - 1.5 * resolution
        return bool(room > distance)

    def _is_near_wall(self, robot: IdealRobot) -> bool:
        """Whether walls can be in the gate's range: not while patrolling close to the border."""
        decision = robot.decision
        return (
            decision is None
            or decision.action not in PATROLLING
            or decision.distance_from_border + self._outline_reach + SLACK > self._border_clearance
        )

    def _wall_points(self, pose: Pose, sight: float) -> NDArray[np.float64]:
        """Return the corners (n, 2), m, map frame, of occupied cells within ``sight`` of a pose."""
        resolution, origin = self._occupancy.resolution, self._occupancy.origin
        row = math.floor((pose.y - origin.y) / resolution)
        col = math.floor((pose.x - origin.x) / resolution)
        size = math.ceil(sight / resolution)
        top, left = max(row - size, 0), max(col - size, 0)
        rows, cols = np.nonzero(self._wall_corners[top : row + size + 2, left : col + size + 2])
        return np.column_stack(
            (origin.x + (cols + left) * resolution, origin.y + (rows + top) * resolution)
        )


def corners_of(walls: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return (rows + 1, cols + 1) which corners of cells belong to a wall (rows, cols)."""
    padded = np.pad(walls, 1)
    return np.asarray(padded[:-1, :-1] | padded[:-1, 1:] | padded[1:, :-1] | padded[1:, 1:])


def _in_map(points: NDArray[np.float64], pose: Pose) -> NDArray[np.float64]:
    c, s = math.cos(pose.theta), math.sin(pose.theta)
    return np.asarray(points @ np.array(((c, s), (-s, c))) + (pose.x, pose.y))

"""What stands about the robot, for the gate: seen now or before, heard, or known to be there."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from drivers.lms200.scan import Scan
from drivers.p2os.base_state import BaseState
from drivers.p2os.model import RobotModel
from maps.occupancy_map import OccupancyMap
from maps.pose import Pose
from robot_agent.motion.gate_limits import GateLimits
from robot_agent.motion.obstacle_points import ObstaclePoints, ObstacleSource
from robot_agent.obstacles.latest_scan import Obstacles
from robot_agent.obstacles.map_obstacles import MapObstacles
from robot_agent.obstacles.recent_scan_memory import RecentScanMemory
from robot_agent.obstacles.sonar_obstacles import SonarObstacles
from robot_agent.obstacles.teammate_keep_out import teammate_keep_out
from robot_agent.obstacles.wall_memory import WallMemory
from robot_agent.perception.scan_points import ScanProjector, move_points
from robot_agent.perception.track import Track
from robot_agent.perception.unexplained import UnexplainedPoints
from robot_agent.pose.odometry_history import OdometryHistory

_JUST_SEEN = 0.6  # s since a teammate was seen that is taken to be there
_NEAR = 2.5  # m; teammates farther off are no obstacle yet


class Surroundings:
    """Points in base_link from laser and sonars, of what it saw before it turned away, from the map
    behind, and of teammates near by."""

    def __init__(
        self,
        laser_mount: Pose,
        gate: GateLimits,
        model: RobotModel,
        occupancy: OccupancyMap,
        unexplained: UnexplainedPoints,
    ) -> None:
        """Take base_from_laser; ``unexplained`` tells walls of the map from all else."""
        self._projector = ScanProjector(laser_mount)
        self._obstacles = Obstacles()
        self._recent_scans = RecentScanMemory(gate)
        self._sonar_obstacles = SonarObstacles(model)
        self._map_obstacles = MapObstacles(occupancy, gate)
        self._wall_memory = WallMemory(gate)
        self._unexplained = unexplained

    @property
    def seen_at(self) -> float | None:
        """When the latest scan was measured, s."""
        return self._obstacles.seen_at

    def on_scan(self, scan: Scan, odometry: Pose, history: OdometryHistory) -> NDArray[np.float64]:
        """Take a scan where odometry was odom_from_base; return its points (n, 2), m, base_link."""
        points = self._projector.points(scan, *history.twist_at(scan.t))
        self._recent_scans.update(
            scan.t, odometry, self._obstacles.around(odometry), self._projector.in_view
        )
        self._obstacles.update(scan.t, odometry, points)
        return points

    def on_located_scan(
        self, odometry: Pose, localized: Pose | None, points: NDArray[np.float64]
    ) -> None:
        """Keep what a scan's points (n, 2), m, base_link show of walls, for when they are behind.

        odometry: odom_from_base; localized: map_from_base while it is known, both at the scan.
        """
        self._recent_scans.lasts = localized is None
        if localized is None:
            self._wall_memory.forget()  # and nobody knows what is a wall
            return
        ranges = np.hypot(points[:, 0], points[:, 1])
        walls = points[~self._unexplained.mask(localized, points, ranges)]
        self._wall_memory.update(odometry, walls)

    def on_sonar(self, state: BaseState, odometry: Pose, model: RobotModel) -> None:
        """Take the sonar echoes of a base report where odometry was odom_from_base."""
        self._sonar_obstacles.update(state, odometry, model)

    def echoes(self, t: float, odometry: Pose) -> NDArray[np.float64]:
        """Return (n, 2) m in base_link: what the sonars hear at t, s."""
        return self._sonar_obstacles.around(t, odometry)

    def seen_around(self, odometry: Pose) -> NDArray[np.float64]:
        """Return what the latest scan saw near the robot, (n, 2) m, in base_link."""
        return self._obstacles.around(odometry)

    def around(
        self, t: float, odometry: Pose, localized: Pose | None, tracks: Sequence[Track]
    ) -> ObstaclePoints:
        """Return what is seen about the robot, and what must be there.

        ``localized``: map_from_base while it is known; without it no sensor, no obstacle.
        """
        parts = [
            (ObstacleSource.LASER, self._obstacles.around(odometry)),
            (ObstacleSource.REMEMBERED, self._left(odometry, localized)),
            (ObstacleSource.SONAR, self._sonar_obstacles.around(t, odometry)),
        ]
        if localized is not None:
            parts += self._unseen_walls(odometry, localized)
            near = [
                (track.x, track.y)
                for track in tracks
                if track.teammate
                and t - track.last_seen <= _JUST_SEEN
                and math.hypot(track.x - localized.x, track.y - localized.y) < _NEAR
            ]
            if near:
                room = teammate_keep_out(move_points(np.array(near), localized.inverse()))
                parts.append((ObstacleSource.TEAMMATE_ROOM, room))
        return ObstaclePoints.joined(parts)

    def _unseen_walls(
        self, odometry: Pose, localized: Pose
    ) -> list[tuple[ObstacleSource, NDArray[np.float64]]]:
        """Return walls of the map, and walls just passed, where the latest scan did not look."""
        mapped, passed = self._map_obstacles.around(localized), self._wall_memory.around(odometry)
        walls = np.concatenate((mapped, passed))
        if not len(walls):
            return []
        unseen = self._unseen(odometry, walls)
        return [
            (ObstacleSource.MAP_WALL, mapped[unseen[: len(mapped)]]),
            (ObstacleSource.REMEMBERED, passed[unseen[len(mapped) :]]),
        ]

    def _unseen(self, odometry: Pose, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return (n,) at which of points (n, 2), m, base_link, the latest scan did not look.

        A robot that turns looks elsewhere by now, but has not seen yet what is there.
        """
        seen_from = self._obstacles.from_scan(odometry, points)
        return ~self._projector.in_view(seen_from)

    def _left(self, odometry: Pose, localized: Pose | None) -> NDArray[np.float64]:
        """Return what was seen before it got out of sight, but for walls that the map tells of:
        these are known, and better."""
        points = self._recent_scans.around(odometry)
        if localized is None or not len(points):
            return points
        ranges = np.hypot(points[:, 0], points[:, 1])
        return points[self._unexplained.mask(localized, points, ranges)]

"""Obstacle points around the robot for the gate, from all sources."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from drivers.p2os.base_state import BaseState
from drivers.p2os.model import RobotModel
from drivers.scan import Scan
from maps.occupancy_map import OccupancyMap
from maps.pose import Pose
from robot_agent.motion.field_of_view import FieldOfView
from robot_agent.motion.footprint import Footprint
from robot_agent.motion.gate_limits import GateLimits
from robot_agent.motion.obstacle_points import ObstaclePoints, ObstacleSource
from robot_agent.obstacles.gone_walls import ASIDE, GoneWalls
from robot_agent.obstacles.latest_scan import Obstacles
from robot_agent.obstacles.map_obstacles import MapObstacles
from robot_agent.obstacles.person_room import PersonRoom
from robot_agent.obstacles.recent_scan_memory import RecentScanMemory
from robot_agent.obstacles.sonar_obstacles import HEARD_WITHIN, SonarObstacles
from robot_agent.obstacles.teammate_keep_out import TeammateKeepOut
from robot_agent.obstacles.wall_memory import WallMemory
from robot_agent.perception.scan_points import ScanProjector, move_points
from robot_agent.perception.track import Track
from robot_agent.perception.unexplained import UnexplainedPoints
from robot_agent.pose.odometry_history import OdometryHistory

_JUST_SEEN = 0.6  # s since the last detection for which a teammate is an obstacle
_PASSING = 0.1  # m/s, ours: a robot that is slower may be standing, by the track's error
_MOVES = 0.25  # m/s, ours: what seems so fast and has a robot's size is one, before it is known
_NEAR = 2.5  # m; teammates farther away are no obstacle yet
_SOON_NEAR = 1.2  # m from the axle; walls of the map farther away do not matter for a while


class Surroundings:
    """Joins the obstacle points of laser, sonars, recent scans, map walls and teammates nearby."""

    def __init__(
        self,
        projector: ScanProjector,
        gate: GateLimits,
        model: RobotModel,
        occupancy: OccupancyMap,
        unexplained: UnexplainedPoints,
    ) -> None:
        """Start without measurements.

        projector: of the laser's scans. gate: limits with the footprint. model: with the sonars'
        geometry. occupancy: the map. unexplained: classifier of points the map does not explain.
        """
        self._projector = projector
        self._obstacles = Obstacles()
        self._recent_scans = RecentScanMemory(gate)
        self._sonar_obstacles = SonarObstacles(model)
        self._map_obstacles = MapObstacles(occupancy, gate)
        self._gone_walls = GoneWalls()
        self._wall_memory = WallMemory(gate)
        self._keep_out = TeammateKeepOut(Footprint(gate))
        self._person_room = PersonRoom(Footprint(gate), gate.turn_margin)
        self._unexplained = unexplained

    @property
    def seen_at(self) -> float | None:
        """When the latest scan was measured; None before the first."""
        return self._obstacles.seen_at

    def on_scan(self, scan: Scan, odometry: Pose, history: OdometryHistory) -> NDArray[np.float64]:
        """Store a scan; return its deskewed points (n, 2), m, base_link at the scan.

        odometry: odom_from_base at the scan; history: gives the base's speeds during the sweep.
        """
        points = self._projector.points(scan, *history.twist_at(scan.t))
        self._recent_scans.update(
            scan.t, odometry, self._obstacles.around(odometry), self._projector.has_measured
        )
        self._obstacles.update(scan.t, odometry, points)
        return points

    def on_located_scan(
        self, t: float, odometry: Pose, localized: Pose | None, points: NDArray[np.float64]
    ) -> None:
        """Store a scan's points on walls, and walls that it shows gone, for when out of view.

        odometry: odom_from_base; localized: map_from_base, None unless localized, both at t, that
        of the scan. points: (n, 2), m, base_link. Without a pose all that is stored is dropped.
        """
        self._recent_scans.lasts = localized is None
        if localized is None:
            self._wall_memory.forget()  # without a pose walls cannot be told from other points
            self._gone_walls.forget()
            return
        self._look_through_walls(t, odometry, localized)
        ranges = np.hypot(points[:, 0], points[:, 1])
        walls = points[~self._unexplained.mask(localized, points, ranges)]
        self._wall_memory.update(odometry, walls)

    def _look_through_walls(self, t: float, odometry: Pose, localized: Pose) -> None:
        """Find walls of the map that the latest scan, at t and these poses, shows to be gone."""
        cells, places = self._map_obstacles.within(_SOON_NEAR, localized)
        if not len(cells):
            self._gone_walls.forget()  # the usual case
            return
        beyond = (
            self._projector.goes_beyond(places, 0.0),
            self._projector.goes_beyond(places, ASIDE),
        )
        self._gone_walls.update(cells, places, beyond, self.echoes(t, odometry))

    def on_sonar(self, state: BaseState, odometry: Pose, localized: Pose | None) -> None:
        """Store the sonar echoes of a base report.

        odometry: odom_from_base; localized: map_from_base, None unless localized, both at the
        report.
        """
        self._sonar_obstacles.update(state, odometry, lambda: self._explaining(odometry, localized))

    def views(self, t: float) -> tuple[FieldOfView, ...]:
        """Return the fields of view, base_link, of the laser and of the front sonars heard by t.

        That of the laser is there from its first scan on; ``seen_at`` tells how old it is.
        """
        return *self._projector.views, *self._sonar_obstacles.views(t)

    def echoes(self, t: float, odometry: Pose) -> NDArray[np.float64]:
        """Return the fresh sonar echoes at t, (n, 2), m, base_link; odometry: odom_from_base."""
        return self._sonar_obstacles.around(t, odometry)

    def seen_around(self, odometry: Pose) -> NDArray[np.float64]:
        """Return the latest scan's points near the robot, (n, 2), m, base_link at odometry."""
        return self._obstacles.around(odometry)

    def around(
        self, t: float, odometry: Pose, localized: Pose | None, tracks: Sequence[Track]
    ) -> ObstaclePoints:
        """Return the obstacle points at t with their sources, m, base_link.

        odometry: odom_from_base. localized: map_from_base, None unless localized; without it only
        measured points are returned, no walls of the map and no teammates. tracks: in the map.
        """
        parts = [
            (ObstacleSource.LASER, self._obstacles.around(odometry)),
            (ObstacleSource.REMEMBERED, self._left(odometry, localized)),
            (ObstacleSource.SONAR, self._sonar_obstacles.around(t, odometry)),
        ]
        if localized is not None:
            parts += self._unseen_walls(odometry, localized)
            parts += self._rooms(t, localized, tracks)
        return ObstaclePoints.joined(parts)

    def _rooms(
        self, t: float, localized: Pose, tracks: Sequence[Track]
    ) -> list[tuple[ObstacleSource, NDArray[np.float64]]]:
        """Return the room that teammates seen lately and people nearby need, as points."""
        near = [
            track
            for track in tracks
            if math.hypot(track.x - localized.x, track.y - localized.y) < _NEAR
        ]
        robots = [track for track in near if self._needs_room(track)]
        teammates = [e for e in robots if t - e.last_seen <= _JUST_SEEN]
        people = [track for track in near if track.person_like]
        to_base = localized.inverse()
        rooms = []
        if teammates:
            passing = np.array([math.hypot(e.vx, e.vy) > _PASSING for e in teammates])
            around = self._keep_out.around(_middles(teammates, to_base), passing)
            rooms.append((ObstacleSource.TEAMMATE_ROOM, around))
        if people:
            around = self._person_room.around(_middles(people, to_base))
            rooms.append((ObstacleSource.PERSON_ROOM, around))
        return rooms

    def _needs_room(self, track: Track) -> bool:
        """Return whether a track is, or may be, a robot whose body needs the room to turn.

        Of a short body what stands and may turn may as well be a box, which would be in the way.
        """
        if self._keep_out.long_body:
            return track.may_turn
        return track.needs_room or (track.may_turn and math.hypot(track.vx, track.vy) > _MOVES)

    def _explaining(self, odometry: Pose, localized: Pose | None) -> NDArray[np.float64]:
        """Return what else the gate knows ahead, (n, 2), m, base_link, and more precisely.

        The laser's points, and walls of the map that it cannot see: a dark door frame gives it no
        return, and the sonars, which hear it, place it in the middle of their cones.
        """
        seen = self._obstacles.around(odometry)
        if localized is None:
            return seen
        walls = self._map_obstacles.within(HEARD_WITHIN, localized).places
        if not len(walls):
            return seen
        return np.concatenate((seen, walls[self._unseen(odometry, walls)]))

    def _unseen_walls(
        self, odometry: Pose, localized: Pose
    ) -> list[tuple[ObstacleSource, NDArray[np.float64]]]:
        """Return walls of the map, and walls just passed, that the latest scan did not measure."""
        mapped = self._map_obstacles.around(localized, self._gone_walls.cells)
        passed = self._wall_memory.around(odometry)
        walls = np.concatenate((mapped, passed))
        if not len(walls):
            return []
        unseen = self._unseen(odometry, walls)
        return [
            (ObstacleSource.MAP_WALL, mapped[unseen[: len(mapped)]]),
            (ObstacleSource.REMEMBERED, passed[unseen[len(mapped) :]]),
        ]

    def _unseen(self, odometry: Pose, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return (n,) which points (n, 2), m, base_link, the latest scan has not measured.

        The view is that of the scan's pose: a robot that turns has no measurement yet of what has
        come into view since.
        """
        seen_from = self._obstacles.from_scan(odometry, points)
        return ~self._projector.has_measured(seen_from)

    def _left(self, odometry: Pose, localized: Pose | None) -> NDArray[np.float64]:
        """Return recent points out of view, m, base_link, without walls that the map has.

        Those come from the map and the wall memory, more precisely.
        """
        points = self._recent_scans.around(odometry)
        if localized is None or not len(points):
            return points
        ranges = np.hypot(points[:, 0], points[:, 1])
        return points[self._unexplained.mask(localized, points, ranges)]


def _middles(tracks: Sequence[Track], to_base: Pose) -> NDArray[np.float64]:
    return move_points(np.array([(track.x, track.y) for track in tracks]), to_base)

"""The simulated world: a map, the bodies in it, their motion, contacts and sensor readings."""

from __future__ import annotations

import math
from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from maps.occupancy_map import OCCUPIED, OccupancyMap
from maps.pose import Pose, wrap_angle
from tools.simulation.fan import Fan, Rays, Returns, ends_of, laser_fan, rays_of, sonar_fan
from tools.simulation.laser_optics import LaserOptics
from tools.simulation.raycast import RayCaster, cast_bodies
from tools.simulation.reflecting_tape import BeamEnds, ends_on_tape
from tools.simulation.robot_body import (
    Outline,
    RobotBody,
    bodies_overlap,
    bumper_masks,
    meeting_points,
)
from tools.simulation.silhouette import Shapes, Silhouette, middles_of, shapes_of
from tools.simulation.sonar_echo import SonarEcho
from tools.simulation.surroundings import Surroundings
from tools.simulation.truth.robot_truth import SonarPlace
from tools.simulation.truth.truth import load_truth
from tools.simulation.truth.world_noise import WorldNoise
from tools.simulation.uneven_floor import UnevenFloor

TOUCH = 0.005  # m; nearer than this is touching
_PART = 0.02  # m; a contact is over when the two are farther apart than this
_SONAR_RANGE = 5.0  # m; also returned when there is no echo


@dataclass(frozen=True, slots=True)
class Motion:
    """Result of a robot's wheel motion: odometry and contacts.

    odometer_distance, odometer_rotation: motion by the encoders, m and rad. blocked: the motion
    was cut short by a wall or a body. front_bumpers, rear_bumpers: bit masks of the segments
    pressed. touching: the outline touches a wall or another body.
    """

    odometer_distance: float
    odometer_rotation: float
    blocked: bool
    front_bumpers: int
    rear_bumpers: int
    touching: bool


@dataclass(frozen=True, slots=True)
class Contact:
    """Contact of two bodies, or of a body and a wall (other is None); bodies by index."""

    body: int
    other: int | None


def plain_noise() -> WorldNoise:
    """Return the noise of the truth ``plain``."""
    return load_truth("plain").noise


class _Parts(NamedTuple):
    """The silhouettes of all bodies, as they are and in a table."""

    silhouettes: list[Sequence[Silhouette]]
    shapes: Shapes


@dataclass(slots=True, eq=False)
class World:
    """The ground truth of a simulation; deterministic under a seeded generator.

    occupancy: what bodies touch. surroundings: the same with what lasers see and sonars hear, where
    that differs. optics: None for walls that are all alike. floor: None for a flat one.
    contact_log: all contacts so far, each once from first touch to separation.
    """

    occupancy: OccupancyMap
    rng: np.random.Generator
    noise: WorldNoise = field(default_factory=plain_noise)
    laser_max_range: float = 32.0  # m
    surroundings: Surroundings | None = None
    optics: LaserOptics | None = None
    echo: SonarEcho | None = None
    floor: UnevenFloor | None = None
    bodies: list[RobotBody] = field(default_factory=list)
    contact_log: list[Contact] = field(default_factory=list)
    _caster: RayCaster = field(init=False)
    _sound: RayCaster = field(init=False)
    _echo: SonarEcho = field(init=False)
    _wall_distance: NDArray[np.float64] = field(init=False)
    _solid: NDArray[np.bool_] = field(init=False)
    _seen: _Parts = field(init=False)
    _heard: _Parts = field(init=False)
    _touching: set[Contact] = field(init=False, default_factory=set)

    def __post_init__(self) -> None:
        around = self.surroundings or Surroundings(*[self.occupancy] * 3)
        self._caster = RayCaster(around.seen)
        self._sound = self._caster if around.heard is around.seen else RayCaster(around.heard)
        self._echo = self.echo or SonarEcho(load_truth("plain").sonar, self.rng)
        self._wall_distance = _distance_to_walls_and_rim(self.occupancy)
        self._solid = np.pad(self.occupancy.cells == OCCUPIED, 1, constant_values=True)
        self._tell_shapes()

    @property
    def contacts(self) -> int:
        """Number of contacts so far."""
        return len(self.contact_log)

    def contact_kinds(self, index: int) -> list[str]:
        """Return what a body, by index, has touched, once a contact: ``wall`` or a body's kind."""
        others = [
            each.other if each.body == index else each.body
            for each in self.contact_log
            if index in (each.body, each.other)
        ]
        return [
            "wall" if other is None else self.bodies[other].kind.name.lower() for other in others
        ]

    def add_body(
        self,
        pose: Pose,
        outline: Outline | None = None,
        silhouettes: tuple[Silhouette, ...] | None = None,
        turn_scale: float = 1.0,
    ) -> RobotBody:
        """Add a robot at a true pose (map_from_base) and draw its odometer's scale errors.

        silhouettes: what lasers see of it, by default its outline. turn_scale: turn of the body
        for a turn of 1 by its wheels.
        Raises ValueError if it would overlap a wall or another body.
        """
        left, right = (1.0 + self.rng.normal(0.0, self.noise.wheel_scale, 2)).tolist()
        body = RobotBody(len(self.bodies), pose, outline or Outline(), (left, right))
        body.silhouettes = silhouettes
        body.turn_scale = turn_scale
        if self._blocked(body, pose):
            raise ValueError(
                f"robot {body.index} at ({pose.x:.2f}, {pose.y:.2f}) stands in a wall or in "
                "another robot: choose another start pose"
            )
        self.bodies.append(body)
        self._tell_shapes()
        return body

    def twin(self) -> World:
        """Return a world of the same walls, without bodies; both share what never changes."""
        other = copy(self)
        other.bodies, other.contact_log, other._touching = [], [], set()
        other._tell_shapes()
        return other

    def move(self, body: RobotBody, distance: float, rotation: float) -> Motion:
        """Move a robot by a wheel motion of distance, m, and rotation, rad.

        Call it for every small step (0.1 s or less), also with 0, 0: other bodies may have moved
        into contact. A blocked robot moves up to the obstacle, and its wheels stop there.
        """
        draws = self.rng.standard_normal(5).tolist()
        slipped = self._slip(distance, rotation * body.turn_scale, draws[:3])
        if self.floor is not None and distance:
            slipped = self._cross_floor(self.floor, body, *slipped)
        wanted = _moved(body.pose, *slipped)
        if self._is_clear(body, wanted):
            body.pose = wanted
            self._end_contacts(body)
            return Motion(*self._odometer(body, distance, rotation, draws[3:]), False, 0, 0, False)
        share = self._free_share(body, *slipped)
        body.pose = _moved(body.pose, slipped[0] * share, slipped[1] * share)
        touched = self._contact_points(body)
        front, rear = bumper_masks(touched, body.outline, body.bumper_segments)
        counted = self._odometer(body, distance * share, rotation * share, draws[3:])
        return Motion(*counted, share < 1.0, front, rear, touching=len(touched) > 0)

    def place(self, body: RobotBody, pose: Pose) -> bool:
        """Move a body without wheels to a nearby pose; return False if the pose is not free."""
        if self._blocked(body, pose):
            return False
        body.pose = pose
        return True

    def show(self, body: RobotBody, silhouettes: tuple[Silhouette, ...]) -> None:
        """Change where the parts of a body are that lasers see; their shapes stay."""
        body.silhouettes = silhouettes
        self._seen.silhouettes[body.index] = silhouettes

    def scan(
        self,
        body: RobotBody,
        pose: Pose,
        n: int,
        increment: float,
        mount: tuple[float, float, float],
        swept: NDArray[np.float64] | float = 0.0,
    ) -> NDArray[np.float64]:
        """Return (n,) laser ranges, m; inf where no return.

        pose: true map_from_base at the time of the scan, which may lie between two moves. Beams
        are symmetric about the laser's axis, the first one right-most, increment rad apart.
        mount: the laser's (x, y, theta) in base_link, m and rad. swept (n,): rad turned by the
        body from then until each beam was measured.
        """
        bearings = (np.arange(n, dtype=np.float64) - (n - 1) / 2) * increment
        return self.scans([laser_fan(body, pose, bearings, mount, swept)])[0].ranges

    def scans(self, fans: Sequence[Fan]) -> list[Returns]:
        """Return the laser's returns for each fan; many in one call cost little more than one."""
        rays = rays_of(fans)
        ranges = self._caster.cast(rays.x, rays.y, rays.angles, self.laser_max_range)
        nearer = self._cast_bodies(rays, self.laser_max_range, self._seen)
        if any(fan.ends is not None for fan in fans):
            nearer = np.minimum(nearer, np.concatenate([ends_of(fan) for fan in fans]))
        n = len(ranges)
        reflectors = self._reflectors(ranges, nearer, rays)
        if self.optics is None:
            ranges = np.minimum(ranges, nearer)
            ranges += self.rng.normal(0.0, self.noise.laser_range, n)
        else:
            ranges = self._measured(self.optics, ranges, nearer, rays, fans)
        ranges[self.rng.random(n) < self.noise.laser_dropouts] = np.inf
        ranges[ranges > self.laser_max_range] = np.inf
        np.maximum(ranges, 0.0, out=ranges)
        ends = np.cumsum([len(fan.angles) for fan in fans])[:-1]
        split = [None] * len(fans) if reflectors is None else np.split(reflectors, ends)
        return [Returns(*each) for each in zip(np.split(ranges, ends), split, strict=True)]

    def free_way(self, x: float, y: float, direction: float) -> float:
        """Return the distance, m, from (x, y) to the next wall in a direction, rad."""
        return float(self.free_ways(x, y, np.array([direction]))[0])

    def free_ways(self, x: float, y: float, directions: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return (n,) distances, m, from (x, y) to the next walls in directions (n,), rad."""
        return self._caster.cast(x, y, directions, self.laser_max_range)

    def sonar(self, body: RobotBody, ring: Sequence[SonarPlace]) -> list[float]:
        """Return each transducer's range, m: the nearest of three rays over its cone, 5 m at most.

        Taken from the body's present pose.
        """
        return self.sonars([body], ring)[0]

    def sonars(self, bodies: Sequence[RobotBody], ring: Sequence[SonarPlace]) -> list[list[float]]:
        """Return the ranges of ``sonar`` for each of several bodies."""
        if not ring:
            return [[] for _ in bodies]
        cone = self._echo.cone
        rays = rays_of([sonar_fan(body, ring, cone) for body in bodies])
        cast = self._sound.cast(rays.x, rays.y, rays.angles, _SONAR_RANGE)
        cast = np.minimum(cast, self._cast_bodies(rays, _SONAR_RANGE, self._heard))
        echoes = self._echo.heard(cast.reshape(-1, len(cone)), len(ring), _SONAR_RANGE)
        echoes += self.rng.normal(0.0, self.noise.sonar_range, echoes.shape)
        heard = np.clip(echoes, 0.0, _SONAR_RANGE).reshape(len(bodies), -1)
        ranges: list[list[float]] = heard.tolist()
        return ranges

    def _tell_shapes(self) -> None:
        """Tabulate what lasers see and what sonars hear of the bodies."""
        heard: list[Sequence[Silhouette]] = [(body.outline.silhouette(),) for body in self.bodies]
        seen: list[Sequence[Silhouette]] = [
            outline if body.silhouettes is None else body.silhouettes
            for body, outline in zip(self.bodies, heard, strict=True)
        ]
        self._seen, self._heard = _Parts(seen, shapes_of(seen)), _Parts(heard, shapes_of(heard))

    def _cast_bodies(self, rays: Rays, max_range: float, parts: _Parts) -> NDArray[np.float64]:
        """Return (n,) ranges, m, to parts of other bodies; inf beside them."""
        if len(self.bodies) < 2:
            return np.full(len(rays.angles), np.inf)
        middles = middles_of(parts.silhouettes, [body.pose for body in self.bodies])
        x, y, angles, own = rays
        return cast_bodies(x, y, angles, middles, parts.shapes, max_range, own)

    def _measured(
        self,
        optics: LaserOptics,
        walls: NDArray[np.float64],
        nearer: NDArray[np.float64],
        rays: Rays,
        fans: Sequence[Fan],
    ) -> NDArray[np.float64]:
        """Return what lasers measure (n,), m, of the ranges to walls and to what else ends rays."""
        ranges = np.minimum(walls, nearer)
        c, s = np.cos(rays.angles), np.sin(rays.angles)
        reached = np.minimum(ranges, self.laser_max_range)
        ends = rays.x + c * reached, rays.y + s * reached
        firsts = np.cumsum([len(fan.angles) for fan in fans]).tolist()
        noise = self.noise.laser_range
        return optics.measured(ranges, ends, (c, s), walls < nearer, firsts, noise, self.rng)

    def _reflectors(
        self, walls: NDArray[np.float64], nearer: NDArray[np.float64], rays: Rays
    ) -> NDArray[np.bool_] | None:
        """Return (n,) which rays return a reflector's light; None where no robot wears tape.

        walls, nearer: (n,) ranges, m, to walls and to what else ends rays.
        """
        tapes = [body.tape for body in self.bodies]
        if not any(tapes):
            return None
        ranges = np.minimum(np.minimum(walls, nearer), self.laser_max_range)
        c, s = np.cos(rays.angles), np.sin(rays.angles)
        ends = BeamEnds(rays.x + c * ranges, rays.y + s * ranges, c, s)
        middles = middles_of(self._seen.silhouettes, [body.pose for body in self.bodies])
        reflectors = ends_on_tape(ends, middles, self._seen.shapes, tapes, self.rng)
        if self.optics is not None:
            reflectors |= self.optics.glares(ends, walls < nearer)
        return reflectors

    def _cross_floor(
        self, floor: UnevenFloor, body: RobotBody, distance: float, rotation: float
    ) -> tuple[float, float]:
        """Return a body's motion with the slip on a doorsill that it comes to."""
        number = floor.number_at(body.pose)
        before, body.floor_patch = body.floor_patch, number
        if number == before or not floor.is_sill(number):
            return distance, rotation
        along, turning = self.rng.standard_normal(2).tolist()
        truth = floor.truth
        lost = min(abs(along * truth.sill_slip), 0.9 * abs(distance))
        return distance - math.copysign(lost, distance), rotation + turning * truth.sill_turn

    def _slip(
        self, distance: float, rotation: float, draws: Sequence[float]
    ) -> tuple[float, float]:
        """Return the motion of a free body for a wheel motion; draws: 3 standard normal numbers."""
        noise = self.noise
        along, turning, veering = draws
        root = math.sqrt(abs(distance))
        return (
            distance + along * noise.slip_distance * root,
            rotation
            + turning * noise.slip_rotation * math.sqrt(abs(rotation))
            + veering * noise.slip_heading * root,
        )

    def _odometer(
        self, body: RobotBody, distance: float, rotation: float, draws: Sequence[float]
    ) -> tuple[float, float]:
        """Return the distance and rotation by the encoders for a wheel motion.

        draws: 2 standard normal numbers, for the left and the right wheel.
        """
        half_track = body.outline.track / 2
        noise = self.noise.odometer
        left, right = (
            wheel * scale + noise * math.sqrt(abs(wheel)) * draw
            for wheel, scale, draw in zip(
                (distance - rotation * half_track, distance + rotation * half_track),
                body.wheel_scales,
                draws,
                strict=True,
            )
        )
        return (left + right) / 2, (right - left) / (2 * half_track)

    def _is_clear(self, body: RobotBody, pose: Pose) -> bool:
        """Whether no wall or body is near enough for a contact at a pose; a fast first test."""
        reach = body.reach + 2 * _PART
        if self.clearance(pose) <= reach:
            return False
        x, y = pose.x, pose.y
        for other in self.bodies:
            if other is not body:
                at = other.pose
                if math.hypot(at.x - x, at.y - y) <= reach + other.reach:
                    return False
        return True

    def _end_contacts(self, body: RobotBody) -> None:
        """Remove all present contacts of a body."""
        if self._touching:
            self._touching.discard(Contact(body.index, None))
            for other in self.bodies:
                self._touching.discard(_contact(body, other))

    def _free_share(self, body: RobotBody, distance: float, rotation: float) -> float:
        """Return the share of a motion, 0 to 1, that is free of walls and bodies."""
        if not self._blocked(body, _moved(body.pose, distance, rotation)):
            return 1.0
        free, blocked = 0.0, 1.0
        for _ in range(7):
            middle = (free + blocked) / 2
            if self._blocked(body, _moved(body.pose, distance * middle, rotation * middle)):
                blocked = middle
            else:
                free = middle
        return free

    def _blocked(self, body: RobotBody, pose: Pose) -> bool:
        """Return whether the body at a pose would overlap a wall or another body."""
        return bool(self._wall_points(body, pose, 0.0).size) or any(
            bodies_overlap(body, pose, other) for other in self._neighbours(body, pose, 0.0)
        )

    def _contact_points(self, body: RobotBody) -> NDArray[np.float64]:
        """Return a body's contact points (n, 2), m, in base_link; log new contacts."""
        points = []
        near = self._wall_points(body, body.pose, _PART).size > 0
        walls = self._wall_points(body, body.pose, TOUCH) if near else np.empty((0, 2))
        if walls.size:
            points.append(walls)
        self._update_contact(Contact(body.index, None), touching=walls.size > 0, near=near)
        close = self._neighbours(body, body.pose, _PART)
        for other in close:
            touching = bodies_overlap(body, body.pose, other, TOUCH)
            if touching:
                points.append(meeting_points(body, other, 2 * TOUCH))
            self._update_contact(
                _contact(body, other),
                touching=touching,
                near=bodies_overlap(body, body.pose, other, _PART),
            )
        for other in self.bodies if self._touching else ():
            if other not in close:
                self._touching.discard(_contact(body, other))
        return np.concatenate(points) if points else np.empty((0, 2))

    def _update_contact(self, contact: Contact, *, touching: bool, near: bool) -> None:
        """Log a contact when it begins; remove it when the two are apart."""
        if touching and contact not in self._touching:
            self._touching.add(contact)
            self.contact_log.append(contact)
        elif not near:
            self._touching.discard(contact)

    def _wall_points(self, body: RobotBody, pose: Pose, margin: float) -> NDArray[np.float64]:
        """Return the points (n, 2), base_link, of an outline grown by a margin that lie in walls.

        The edge of the map counts as a wall.
        """
        if self.clearance(pose) > body.reach + 2 * margin:
            return np.empty((0, 2))  # the usual case
        outline = body.outline.grown(margin) if margin else body.outline
        points = outline.perimeter(self.occupancy.resolution / 2)
        c, s = math.cos(pose.theta), math.sin(pose.theta)
        in_map = points @ np.array(((c, s), (-s, c))) + (pose.x, pose.y)
        cells = np.floor((in_map - self.occupancy.origin[:2]) / self.occupancy.resolution)
        rows, cols = self._solid.shape
        cells = np.minimum(np.maximum(cells + 1.0, 0.0), (cols - 1.0, rows - 1.0)).astype(np.intp)
        in_wall = self._solid.take(cells[:, 1] * cols + cells[:, 0])
        return np.asarray(points[in_wall])

    def clearance(self, pose: Pose) -> float:
        """Return a lower bound of the distance to the nearest wall, m; 0 outside the map."""
        resolution, origin = self.occupancy.resolution, self.occupancy.origin
        row = math.floor((pose.y - origin.y) / resolution)
        col = math.floor((pose.x - origin.x) / resolution)
        rows, cols = self._wall_distance.shape
        if not (0 <= row < rows and 0 <= col < cols):
            return 0.0
        # Half a cell's diagonal for the wall's cell, and for the pose's.
        return float(self._wall_distance[row, col]) - math.sqrt(2.0) * resolution

    def _neighbours(self, body: RobotBody, pose: Pose, margin: float) -> list[RobotBody]:
        """Return the other bodies near enough to overlap the body at a pose."""
        return [
            other
            for other in self.bodies
            if other is not body
            and math.hypot(other.pose.x - pose.x, other.pose.y - pose.y)
            <= body.reach + other.reach + 2 * margin
        ]


def _contact(body: RobotBody, other: RobotBody) -> Contact:
    return Contact(min(body.index, other.index), max(body.index, other.index))


def _distance_to_walls_and_rim(occupancy: OccupancyMap) -> NDArray[np.float64]:
    """Return (rows, cols) distances, m, to the nearest wall's cell or to the edge of the map."""
    rows, cols = occupancy.cells.shape
    row, col = np.arange(rows)[:, None], np.arange(cols)[None, :]
    rim = np.minimum(np.minimum(row, rows - 1 - row), np.minimum(col, cols - 1 - col))
    return np.asarray(np.minimum(occupancy.distance_field(), rim * occupancy.resolution))


def _moved(pose: Pose, distance: float, rotation: float) -> Pose:
    """Return the pose after an arc, moved along its chord."""
    half = rotation / 2
    chord = distance * (math.sin(half) / half if half else 1.0)
    heading = pose.theta + half
    return Pose(
        pose.x + chord * math.cos(heading),
        pose.y + chord * math.sin(heading),
        wrap_angle(pose.theta + rotation),
    )

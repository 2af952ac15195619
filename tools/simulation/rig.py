"""One emulated robot: base and laser on their lines and a body in the world."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from drivers.p2os.base_state import ChargeState
from drivers.p2os.emulator.base import FACTORY_WATCHDOG
from drivers.p2os.emulator.emulator import P2osEmulator
from drivers.p2os.emulator.firmware import Firmware
from drivers.p2os.emulator.make import BaseMake
from maps.pose import Pose, wrap_angle
from tools.simulation.emulated_laser import beam_delays, make_laser
from tools.simulation.fan import Fan, Returns, laser_fan
from tools.simulation.laser_start import LaserStart
from tools.simulation.laser_unit import LaserUnit
from tools.simulation.robot_body import Outline, RobotBody
from tools.simulation.silhouette import silhouette_of
from tools.simulation.truth.robot_truth import RobotTruth
from tools.simulation.truth.truth import Truth, load_truth
from tools.simulation.world import World

SONAR_PERIOD_S = 0.1
_AS_BOUGHT = LaserStart()
_OPEN_INPUTS = 0x7F  # all segments of a bumper byte above the stall bit: FE


class RobotRig:
    """Moves a body by its base's wheel motion; laser and sonars measure from its true pose."""

    def __init__(
        self,
        name: str,
        world: World,
        body: RobotBody,
        t: float,
        *,
        firmware: Firmware | None = None,
        baud: int = 9600,
        watchdog: float = FACTORY_WATCHDOG,
        truth: RobotTruth | None = None,
        laser_start: LaserStart = _AS_BOUGHT,
    ) -> None:
        """Make the devices of a body in the world, powered on at ``t``.

        truth: how the robot really is, by default as the shipped ``plain``.
        firmware: of the base's controller, by default the truth's. baud: rate at which its line
        starts. watchdog: value in the base's FLASH, s. laser_start: how the laser is found.
        """
        self.name = name
        self.world = world
        self.body = body
        self.truth = truth or load_truth("plain").robot
        charging = self.truth.charging.connected
        self.base = P2osEmulator(
            make_of(self.truth),
            baud=baud,
            name=name,
            firmware=firmware or Firmware(self.truth.base.firmware),
            watchdog=watchdog,
            clock=self.truth.base.clock,
        )
        self.base.base.braking = self.truth.drive.braking
        if charging:
            self.base.battery.charge_state = ChargeState.BULK
        self.laser = make_laser(
            self.truth.laser.kind, self._scan, lambda: self._measured.reflectors, laser_start, t
        )
        self._unit = LaserUnit(self.truth.laser, t, world.rng.spawn(1)[0])
        self.stuck = False
        """Whether the body cannot move while the wheels turn."""
        self.blind = False
        """Whether no beam of the laser returns."""
        self.bumped = 0
        """Bit mask of front bumper segments pressed in addition to the world's contacts."""
        self._next_sonar = t
        self._prepared: Returns | None = None
        self._measured = Returns(np.empty(0), None)  # of the latest mirror turn
        self._repeated: Returns | None = None
        self._repeats_from = t + self.truth.laser.repeats_from
        self._t = self._previous_t = t
        self._previous_pose = body.pose

    def advance(self, t: float) -> None:
        """Advance to ``t``: wheels turn, the body moves or bumps, the sensors measure."""
        self.move(t)
        sense([self], t)

    def move(self, t: float) -> None:
        """Advance to ``t``: wheels turn, the body moves or bumps. Call ``sense`` after it."""
        distance, rotation = self.base.advance(t)
        self._previous_t, self._t = self._t, t
        self._previous_pose = self.body.pose
        motion = self.world.move(self.body, *((0.0, 0.0) if self.stuck else (distance, rotation)))
        self.base.turn_odometer(motion.odometer_distance, motion.odometer_rotation)
        fitted = self.truth.bumpers.fitted
        self.base.set_contact(
            stalled=motion.blocked or (self.stuck and (distance, rotation) != (0.0, 0.0)),
            front_bumpers=motion.front_bumpers | self.bumped if fitted else _OPEN_INPUTS,
            rear_bumpers=motion.rear_bumpers if fitted else _OPEN_INPUTS,
        )

    def pop_sonar_due(self, t: float) -> bool:
        """Return whether a sonar measurement is due at ``t``, and schedule the next one if so."""
        if t < self._next_sonar:
            return False
        self._next_sonar += SONAR_PERIOD_S
        return True

    def next_fan(self, t: float) -> Fan | None:
        """Return the rays of the mirror turn that is due by ``t``, None if there is none."""
        turn = self.laser.turn_due(t)
        return None if turn is None else self._fan(*turn[:3])

    def on_returns(self, t: float, returns: Returns | None) -> None:
        """Advance the laser to ``t``; returns of the rays from ``next_fan``, or None."""
        self._prepared = returns
        self.laser.advance(t)

    def place(self, pose: Pose) -> None:
        """Move the robot to a true pose, map_from_base; its wheels do not turn."""
        self.body.pose = self._previous_pose = pose

    def _scan(self, t: float, n: int, increment: float) -> NDArray[np.float64]:
        """Return the ranges of one mirror turn at ``t``, which lies within the present step."""
        self._measured = self._measure(t, n, increment)
        return self._measured.ranges

    def _measure(self, t: float, n: int, increment: float) -> Returns:
        prepared, self._prepared = self._prepared, None
        if self.blind:
            return Returns(np.full(n, np.inf), None)
        if prepared is None:
            prepared = self.world.scans([self._fan(t, n, increment)])[0]
        ranges = self._unit.reported(prepared.ranges, self._bearings(n, increment), t)
        returns = prepared._replace(ranges=ranges)
        return returns if t < self._repeats_from else self._repeat(returns)

    def _repeat(self, returns: Returns) -> Returns:
        """Return the scan that the laser repeats, with the noise of the range added."""
        if self._repeated is None or len(self._repeated.ranges) != len(returns.ranges):
            self._repeated = returns
        noise = self.world.rng.normal(0.0, self.world.noise.laser_range, len(returns.ranges))
        return self._repeated._replace(ranges=np.maximum(self._repeated.ranges + noise, 0.0))

    def _fan(self, t: float, n: int, increment: float) -> Fan:
        """Return the rays of a mirror turn.

        The base turns while the mirror sweeps, which shifts the direction of each beam.
        """
        pose = self._pose_at(t)
        step = self._t - self._previous_t
        turn = math.remainder(self.body.pose.theta - self._previous_pose.theta, math.tau)
        rate = turn / step if step > 0 else 0.0
        offsets = beam_delays(self.laser, n, increment)
        laser = self.truth.laser
        # Mirrored data come in the reverse order of their measurement.
        swept = rate * (offsets[::-1] if laser.mirrored else offsets)
        bearings = self._bearings(n, increment)
        fan = laser_fan(self.body, pose, bearings, laser.mount, swept)
        floor = self.world.floor
        pitch = 0.0 if floor is None else floor.pitch(self.body.floor_patch, pose.theta)
        return fan._replace(ends=self._unit.ends(bearings, pitch))

    def _bearings(self, n: int, increment: float) -> NDArray[np.float64]:
        """Return (n,) directions of the beams from the laser's axis, rad, left positive."""
        laser = self.truth.laser
        bearings = (np.arange(n, dtype=np.float64) - (n - 1) / 2) * increment
        return bearings if laser.upside_down == laser.mirrored else -bearings

    def _pose_at(self, t: float) -> Pose:
        """Return the true pose at ``t``, interpolated within the last step."""
        step = self._t - self._previous_t
        share = min(max((t - self._previous_t) / step, 0.0), 1.0) if step > 0 else 1.0
        a, b = self._previous_pose, self.body.pose
        turn = math.remainder(b.theta - a.theta, math.tau)
        return Pose(
            a.x + share * (b.x - a.x),
            a.y + share * (b.y - a.y),
            wrap_angle(a.theta + share * turn),
        )


def sense(rigs: Sequence[RobotRig], t: float) -> None:
    """Measure with the sonars and lasers of robots that have moved to ``t``, all in one pass.

    The robots are in one world and have their sonars at the same places.
    """
    due_rigs = [rig for rig in rigs if rig.pop_sonar_due(t)]
    if due_rigs:
        world, ring = due_rigs[0].world, due_rigs[0].truth.base.sonar
        echoes = world.sonars([rig.body for rig in due_rigs], ring)
        for rig, ranges in zip(due_rigs, echoes, strict=True):
            for number in rig.truth.base.no_sonar:
                ranges[number] = math.inf
            rig.base.set_sonar(ranges)
    fans = [rig.next_fan(t) for rig in rigs]
    due = [fan for fan in fans if fan is not None]
    scans = iter(rigs[0].world.scans(due) if due else ())
    for rig, fan in zip(rigs, fans, strict=True):
        rig.on_returns(t, None if fan is None else next(scans))


def make_of(truth: RobotTruth) -> BaseMake:
    """Return the make of a robot's base."""
    base = truth.base
    return BaseMake(
        subclass=truth.subclass,
        top_speed=base.top_speed,
        top_turn_rate_deg=base.top_turn_rate_deg,
        transducers=len(base.sonar),
        sonar_far=base.sonar_far,
        bumper_segments=truth.bumpers.segments,
        battery=base.battery,
        heading_counts=base.heading_counts,
        distance_count=base.distance_count,
        speed_count=base.speed_count,
        range_count=base.range_count,
        wheel_speed_count=base.wheel_speed_count,
        turn=base.turn,
    )


def outline_of(truth: RobotTruth) -> Outline:
    """Return what of a robot can touch."""
    body = truth.body
    return Outline(body.front, body.rear, body.half_width, body.track, body.corners)


def make_rigs(
    world: World, starts: Sequence[Pose], t: float, truth: Truth | None = None
) -> list[RobotRig]:
    """Add one robot per start pose to the world: robot1, robot2, ...

    truth: how the robots really are, by default as the shipped ``plain``; what it leaves to the
    seed is drawn for each.
    """
    truth = truth or load_truth("plain")
    draws = world.rng.spawn(1)[0]
    return [
        make_rig(f"robot{number}", world, start, t, truth.drawn(draws).robot)
        for number, start in enumerate(starts, start=1)
    ]


def make_rig(
    name: str,
    world: World,
    start: Pose,
    t: float,
    robot: RobotTruth,
    *,
    firmware: Firmware | None = None,
    baud: int = 9600,
    watchdog: float = FACTORY_WATCHDOG,
    laser_start: LaserStart = _AS_BOUGHT,
) -> RobotRig:
    """Add one robot to the world; raises ValueError where there is no room.

    firmware, baud, watchdog: as of RobotRig.
    """
    silhouettes = tuple(silhouette_of(corners) for corners in robot.silhouette.polygons)
    body = world.add_body(start, outline_of(robot), silhouettes, robot.drive.turn_scale)
    body.bumper_segments = robot.bumpers.segments
    body.tape = robot.tape if robot.tape.worn else None
    return RobotRig(
        *(name, world, body, t),
        firmware=firmware,
        baud=baud,
        watchdog=watchdog,
        truth=robot,
        laser_start=laser_start,
    )

"""The bodies of all robots: their bases' ramps, motion along arcs, contacts by the world."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from drivers.p2os.set_up import ACCELERATION, DECELERATION, TURN_ACCELERATION, TURN_DECELERATION
from maps.pose import Pose
from tools.batch.angles import remainders
from tools.batch.arrays import Flags, Indices, Reals, pick
from tools.simulation.robot_body import Outline
from tools.simulation.world import World

STEP_WAY = 0.06  # m; upper bound of the motion of one step
_CONTACT_ROOM = 0.05  # m beyond the reach of two bodies within which the world looks for contacts
_IN_TIME = 1e-9  # s
REACH = Outline().reach
"""Distance of a body's farthest corner from base_link, m."""


class Bodies:
    """True poses and speeds of the robots of all runs; robots of one run may touch."""

    def __init__(self, world: World, starts: Sequence[Sequence[Pose]]) -> None:
        """world: of the walls; each run with robots near each other gets a twin of it."""
        poses = np.array([pose for run in starts for pose in run]).reshape(-1, 3)
        self.x, self.y, self.theta = np.ascontiguousarray(poses.T)
        self.v, self.w = np.zeros((2, len(self.x)))
        self._count = len(starts[0])
        self._walls = world
        self._worlds: dict[int, World] = {}
        self._turned()

    @property
    def shared(self) -> tuple[object, ...]:
        """What copies need not copy: it never changes, or is made again."""
        return self._walls, self._worlds

    def roll(self, order: tuple[Reals, Reals], stuck: Flags, dt: float) -> tuple[Reals, Reals]:
        """Advance the ramps by dt, s, to ordered (v, w); return ways, m, and rotations, rad.

        stuck: whose wheels do not turn.
        """
        self.v, way = _ramps(self.v, order[0], ACCELERATION, DECELERATION, dt)
        self.w, rotation = _ramps(self.w, order[1], TURN_ACCELERATION, TURN_DECELERATION, dt)
        if stuck.any():
            self.v[stuck] = self.w[stuck] = way[stuck] = rotation[stuck] = 0.0
        return way, rotation

    def move(self, way: Reals, rotation: Reals, closest: Reals, near_walls: Flags) -> None:
        """Move all robots along arcs; those near walls or others by the world.

        closest: (n,) m to the nearest robot of the run before.
        """
        room = 2.0 * (REACH + STEP_WAY) + _CONTACT_ROOM
        by_world = ((closest <= room) | near_walls).nonzero()[0]
        kept = self.x[by_world], self.y[by_world], self.theta[by_world]
        half = rotation / 2.0
        turning = half.nonzero()[0]
        chord = way.copy()
        chord[turning] *= np.sin(half[turning]) / half[turning]
        heading = self.theta + half
        self.x = self.x + chord * np.cos(heading)
        self.y = self.y + chord * np.sin(heading)
        self.theta = remainders(self.theta + rotation)
        self.x[by_world], self.y[by_world], self.theta[by_world] = kept
        for run in np.unique(by_world // self._count).tolist():
            own = by_world[by_world // self._count == run]
            self._move_by_world(run, own.tolist(), way, rotation)
        self._turned()

    def pick(self, robots: Indices) -> None:
        """Keep some robots, as ``arrays.pick`` does; contacts are counted anew."""
        pick(self, ("x", "y", "theta", "v", "w", "cos", "sin"), robots)
        self._worlds = {}

    def contacts(self, run: int) -> int:
        """Return the number of contacts in a run so far."""
        world = self._worlds.get(run)
        return world.contacts if world else 0

    def pose(self, robot: int) -> Pose:
        """Return a robot's pose."""
        return Pose(float(self.x[robot]), float(self.y[robot]), float(self.theta[robot]))

    def _turned(self) -> None:
        self.cos, self.sin = np.cos(self.theta), np.sin(self.theta)

    def world(self, run: int) -> World:
        """Return the world of a run's robots, which keeps their contacts."""
        if run not in self._worlds:
            self._worlds[run] = self._populated(run)
        return self._worlds[run]

    def _move_by_world(self, run: int, robots: list[int], way: Reals, rotation: Reals) -> None:
        """Move some robots of a run, in order, as the world lets them."""
        world = self.world(run)
        first = run * self._count
        for robot, body in enumerate(world.bodies, first):
            body.pose = self.pose(robot)
        for robot in robots:
            body = world.bodies[robot - first]
            world.move(body, float(way[robot]), float(rotation[robot]))
            self.x[robot], self.y[robot], self.theta[robot] = body.pose

    def _populated(self, run: int) -> World:
        """Return a world of a run's robots."""
        world = self._walls.twin()
        for robot in range(run * self._count, (run + 1) * self._count):
            world.add_body(self.pose(robot))
        return world


def _ramps(speed: Reals, goal: Reals, up: float, down: float, dt: float) -> tuple[Reals, Reals]:
    """Return new speeds and ways of ``motion_controller.ramp`` for each of many."""
    some = (speed != goal).nonzero()[0]
    if not some.size:
        return speed.copy(), speed * dt
    before, to = speed[some], goal[some]
    forward = to * before > 0.0
    slows = (to * before < 0.0) | (np.abs(to) < np.abs(before))
    slowest = np.where(forward, to, 0.0)
    now, way, left = _approached(before, np.where(slows, slowest, before), down, dt)
    now, more, left = _approached(now, to, up, left)
    speeds, ways = speed.copy(), speed * dt
    speeds[some], ways[some] = now, way + more + now * left
    return speeds, ways


def _approached(
    speed: Reals, goal: Reals, rate: float, dt: Reals | float
) -> tuple[Reals, Reals, Reals]:
    """Return new speeds, ways and times left of ``motion_controller.approach``."""
    needed = np.abs(goal - speed) / rate
    in_time = needed <= dt + _IN_TIME
    reached = speed + np.copysign(rate * dt, goal - speed)
    now = np.where(in_time, goal, reached)
    way = 0.5 * (speed + now) * np.where(in_time, needed, dt)
    return now, way, np.where(in_time, np.maximum(dt - needed, 0.0), 0.0)

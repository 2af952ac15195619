"""Strangers in the simulated world: people and carts that move near the border.

They move between random goals in straight lines, pause at goals, do not plan round corners, and
stop before robots.
"""

from __future__ import annotations

import math

import numpy as np

from maps.border import Border
from maps.pose import Pose
from tools.simulation.legs import Legs
from tools.simulation.robot_body import BodyKind, Outline
from tools.simulation.world import World

PERSON = Outline(0.14, 0.14, 0.22)
"""Shoulders 0.44 m, depth 0.28 m."""
BOX = Outline(0.35, 0.35, 0.3)
"""A cart with boxes: 0.7 by 0.6 m."""
_SPEEDS = (0.5, 1.1)  # m/s
_PAUSES = (0.0, 8.0)  # s at a goal
_NEAR_BORDER = 1.8  # m; most goals lie within this distance
_AWAY_SHARE = 0.3  # of the goals lie farther from the border
_FARTHEST_LEG = 8.0  # m
_CLEARANCE = 0.45  # m kept from walls
_STOP_DISTANCE = 0.9  # m ahead within which a robot makes a stranger stop
_MAX_WAIT = 2.0  # s before another goal is chosen
_TRIES = 400


class StrangerError(ValueError):
    """The map has no room for a stranger."""


class Stranger:
    """One person or cart, moved by ``advance``."""

    def __init__(
        self,
        world: World,
        border: Border,
        kind: BodyKind,
        rng: np.random.Generator,
        leg: float = 0.0,
    ) -> None:
        """Add the body at a free place of the world; raises StrangerError if there is none.

        leg: width of a person's legs, m; 0 for a person as wide as its shoulders everywhere.
        """
        self._world = world
        self._border = border
        self._rng = rng
        self._speed = 0.0
        self._rest = 0.0  # s left of the pause
        self._waited = 0.0  # s stopped before a robot
        outline = PERSON if kind is BodyKind.PERSON else BOX
        x, y = self._free_place()
        self._legs = Legs(leg) if leg and kind is BodyKind.PERSON else None
        self._walked = 0.0
        silhouettes = None if self._legs is None else self._legs.at(self._walked)
        pose = Pose(x, y, float(rng.uniform(-math.pi, math.pi)))
        self.body = world.add_body(pose, outline, silhouettes)
        self.body.kind = kind
        self._goal = (x, y)

    def advance(self, dt: float) -> None:
        """Advance by ``dt``, s."""
        if self._rest > 0.0:
            self._rest -= dt
            return
        pose = self.body.pose
        dx, dy = self._goal[0] - pose.x, self._goal[1] - pose.y
        distance = math.hypot(dx, dy)
        if distance < 0.05:
            self._choose_goal()
            return
        heading = math.atan2(dy, dx)
        if self._robot_ahead(pose, heading):
            self._waited += dt
            if self._waited > _MAX_WAIT:
                self._choose_goal()
            return
        self._waited = 0.0
        step = min(self._speed * dt, distance)
        ahead = Pose(pose.x + step * math.cos(heading), pose.y + step * math.sin(heading), heading)
        if not self._world.place(self.body, ahead):
            self._choose_goal()
        elif self._legs is not None:
            self._walked += step
            self._world.show(self.body, self._legs.at(self._walked))

    def _choose_goal(self) -> None:
        """Draw a pause, a speed and the next goal in line of sight."""
        rng, pose = self._rng, self.body.pose
        self._waited = 0.0
        self._rest = float(rng.uniform(*_PAUSES))
        self._speed = float(rng.uniform(*_SPEEDS))
        away = rng.random() < _AWAY_SHARE
        for _ in range(_TRIES):
            heading = float(rng.uniform(-math.pi, math.pi))
            reach = self._world.free_way(pose.x, pose.y, heading) - _CLEARANCE - 0.2
            leg = float(rng.uniform(0.5, _FARTHEST_LEG))
            if leg > reach:
                continue
            x, y = pose.x + leg * math.cos(heading), pose.y + leg * math.sin(heading)
            near = self._border.project(x, y).distance < _NEAR_BORDER
            if near != away and self._is_clear(pose, heading, leg):
                self._goal = (x, y)
                return

    def _is_clear(self, pose: Pose, heading: float, leg: float) -> bool:
        """Whether a straight path of ``leg`` m keeps its clearance from walls."""
        return all(
            self._world.clearance(
                Pose(pose.x + s * math.cos(heading), pose.y + s * math.sin(heading), 0.0)
            )
            > _CLEARANCE
            for s in np.arange(0.2, leg + 0.1, 0.2).tolist()
        )

    def _robot_ahead(self, pose: Pose, heading: float) -> bool:
        """Whether a robot or another stranger is ahead within the stop distance."""
        c, s = math.cos(heading), math.sin(heading)
        for other in self._world.bodies:
            if other is self.body:
                continue
            dx, dy = other.pose.x - pose.x, other.pose.y - pose.y
            ahead, beside = c * dx + s * dy, abs(c * dy - s * dx)
            room = self.body.reach + other.reach
            if ahead > 0.0 and ahead < room + _STOP_DISTANCE and beside < room + 0.1:
                return True
        return False

    def _free_place(self) -> tuple[float, float]:
        """Return a position near the border, clear of walls and of all bodies."""
        border, rng = self._border, self._rng
        for _ in range(_TRIES):
            foot = border.at(float(rng.uniform(0.0, border.length)))
            aside = float(rng.uniform(-_NEAR_BORDER, _NEAR_BORDER))
            x, y = foot.x - aside * foot.ty, foot.y + aside * foot.tx
            free = self._world.clearance(Pose(x, y, 0.0)) > _CLEARANCE + 0.1
            if free and all(
                math.hypot(body.pose.x - x, body.pose.y - y) > 1.5 for body in self._world.bodies
            ):
                return x, y
        raise StrangerError("there is no free place for a stranger: fewer --strangers")


def make_strangers(
    world: World, border: Border, count: int, seed: int, leg: float = 0.0
) -> list[Stranger]:
    """Add strangers to the world, persons and carts in turn; each has its own random generator.

    leg: width of the persons' legs, m; 0 for persons as wide as their shoulders everywhere.
    """
    kinds = (BodyKind.PERSON, BodyKind.BOX)
    return [
        Stranger(world, border, kinds[number % 2], np.random.default_rng((seed, 77, number)), leg)
        for number in range(count)
    ]

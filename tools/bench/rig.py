"""One emulated robot: two devices on the wire and a body in the world."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from drivers.lms200.emulator import Lms200Emulator
from drivers.p2os.emulator import P2osEmulator
from drivers.p2os.model import load_model
from maps.pose import Pose, wrap_angle
from tools.bench.robot_body import RobotBody
from tools.bench.world import World

SONAR_PERIOD_S = 0.1


class RobotRig:
    """Moves a body as its base's wheels turn; the laser and the sonars see from where it is."""

    def __init__(
        self,
        name: str,
        world: World,
        body: RobotBody,
        t: float,
        model: str = "p2dx",
        *,
        later_firmware: bool = False,
    ) -> None:
        """Put the robot into the world at time t, both devices just powered; with
        ``later_firmware`` its base reports what AROS does, the stop button among it."""
        self.name = name
        self.world = world
        self.body = body
        self._model = load_model(model)
        self.base = P2osEmulator(self._model, name=name, later_firmware=later_firmware)
        self.laser = Lms200Emulator(scan_source=self._scan)
        self.stuck = False
        """Whether something holds the wheels."""
        self._next_sonar = t
        self._t = self._previous_t = t
        self._previous_pose = body.pose

    def advance(self, t: float) -> None:
        """Let time pass to t: wheels turn, the body moves or bumps, the sensors see."""
        distance, rotation = self.base.advance(t)
        self._previous_t, self._t = self._t, t
        self._previous_pose = self.body.pose
        motion = self.world.move(self.body, *((0.0, 0.0) if self.stuck else (distance, rotation)))
        self.base.turn_odometer(motion.odometer_distance, motion.odometer_rotation)
        self.base.set_contact(
            stalled=motion.blocked or (self.stuck and (distance, rotation) != (0.0, 0.0)),
            front_bumpers=motion.front_bumpers,
            rear_bumpers=motion.rear_bumpers,
        )
        if t >= self._next_sonar:
            self.base.set_sonar(self.world.sonar(self.body, self._model.sonar))
            self._next_sonar += SONAR_PERIOD_S
        self.laser.advance(t)

    def carry_left(self, distance: float) -> None:
        """Put the robot down a distance, m, to its left; its wheels do not turn."""
        self.body.pose = self.body.pose.compose(Pose(0.0, distance, 0.0))
        self._previous_pose = self.body.pose

    def _scan(self, t: float, n: int, increment: float) -> NDArray[np.float64]:
        """Measure one scan at time t, which lies within the present step."""
        pose = self._pose_at(t)
        return self.world.scan(self.body, pose, n, increment, self._model.laser_mount)

    def _pose_at(self, t: float) -> Pose:
        """Interpolate the true pose within the last step."""
        step = self._t - self._previous_t
        share = min(max((t - self._previous_t) / step, 0.0), 1.0) if step > 0 else 1.0
        a, b = self._previous_pose, self.body.pose
        turn = math.remainder(b.theta - a.theta, math.tau)
        return Pose(
            a.x + share * (b.x - a.x),
            a.y + share * (b.y - a.y),
            wrap_angle(a.theta + share * turn),
        )


def make_rigs(world: World, starts: Sequence[Pose], t: float) -> list[RobotRig]:
    """Add one robot per start pose to the world: robot1, robot2, ..."""
    return [
        RobotRig(f"robot{number}", world, world.add_body(start), t)
        for number, start in enumerate(starts, start=1)
    ]

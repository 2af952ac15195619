"""One robot of the ideal bench: the agent's decision layer on a simulated body."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from drivers.p2os.emulator.motion_controller import ramp
from drivers.p2os.model_choice import expected_model
from drivers.p2os.set_up import ACCELERATION, DECELERATION, TURN_ACCELERATION, TURN_DECELERATION
from maps.map_folder import MapFolder
from maps.pose import Pose
from robot_agent.config import AgentConfig
from robot_agent.motion.field_of_view import FieldOfView
from robot_agent.motion.gate import GateDecision, GateInputs, SafetyGate
from robot_agent.motion.gate_hold import begins_hold, held_by_obstacle, pinned_by_obstacle
from robot_agent.motion.gate_settings import gate_limits
from robot_agent.motion.heading_loop import HeadingLoop
from robot_agent.motion.unpinning import UnpinningManoeuvre
from robot_agent.patrol.common_clock import CommonClock
from robot_agent.patrol.patrol import Patrol, PatrolDecision
from tools.simulation.robot_body import RobotBody

STEP_S = 0.1
"""Period of a control step, s: the base reports 10 times a second."""
_ALL_ROUND = (FieldOfView(0.0, 0.0, 0.0, math.pi, math.inf),)
_BATTERY = 13.0  # V; full, constant


@dataclass(slots=True, eq=False)
class IdealRobot:
    """Patrol, heading loop and gate of the agent; v and w (m/s, rad/s) follow the base's ramps.

    stuck: the wheels do not turn. dead: no decisions are made, and the base stands.
    """

    name: str
    body: RobotBody
    patrol: Patrol
    heading_loop: HeadingLoop
    unpinning: UnpinningManoeuvre
    gate: SafetyGate
    v: float = 0.0
    w: float = 0.0
    stuck: bool = False
    dead: bool = False
    decision: PatrolDecision | None = None
    gate_decision: GateDecision | None = None
    gate_stops: int = 0
    _order: tuple[float, float] = field(default=(0.0, 0.0))

    @property
    def fastest(self) -> float:
        """The greater of the present and the commanded speed, m/s."""
        return max(self.v, self._order[0])

    def roll(self, dt: float) -> tuple[float, float]:
        """Advance the ramps by dt, s; return the wheels' distance, m, and rotation, rad."""
        v, w = (0.0, 0.0) if self.dead else self._order
        self.v, distance = ramp(self.v, v, ACCELERATION, DECELERATION, dt)
        self.w, rotation = ramp(self.w, w, TURN_ACCELERATION, TURN_DECELERATION, dt)
        if self.stuck:
            self.v = self.w = distance = rotation = 0.0
        return distance, rotation

    def decide(
        self, t: float, teammate: tuple[float, float] | None, obstacles: NDArray[np.float64]
    ) -> None:
        """Run one control step at t, as the agent does.

        teammate: (x, y) of the closest teammate, m, map frame, or None. obstacles: (n, 2), m, in
        base_link.
        """
        pose = self.body.pose
        decision = self.patrol.step(t, pose, teammate, held=held_by_obstacle(self.gate_decision))
        pinned = pinned_by_obstacle(self.gate_decision)
        unpinning = self.unpinning.step(t, self.heading_loop.turn, pinned=pinned)
        requested = self.heading_loop.command(
            t, decision.velocity, pose.theta, decision.curvature, unpinning
        )
        inputs = GateInputs(
            base_time=t,
            scan_time=t,
            health="localized",
            body_known=True,
            charging=False,
            motors_enabled=True,
            stop_button=False,
            stalled=False,
            bumpers=0,
            battery=_BATTERY,
            obstacles=obstacles,
            v=self.v,
            w=self.w,
            views=_ALL_ROUND,
        )
        gate = self.gate.permit(t, requested, inputs)
        self.gate_stops += begins_hold(self.gate_decision, gate)
        self.decision, self.gate_decision = decision, gate
        self._order = (gate.v, gate.w)


def make_ideal_robot(body: RobotBody, config: AgentConfig, folder: MapFolder) -> IdealRobot:
    """Return the robot of a body with a configuration, on a map with a border."""
    assert folder.border is not None
    rng = np.random.default_rng(config.robot.seed)
    return IdealRobot(
        name=config.robot.name,
        body=body,
        patrol=Patrol(config.patrol, folder.border, rng, folder.approach_field, CommonClock(0.0)),
        heading_loop=HeadingLoop(),
        unpinning=UnpinningManoeuvre(),
        gate=SafetyGate(gate_limits(config.gate, expected_model(config.base))),
    )


def along_arc(pose: Pose, distance: float, rotation: float) -> Pose:
    """Return the pose after an arc of distance, m, and rotation, rad."""
    half = rotation / 2.0
    chord = distance * (math.sin(half) / half if half else 1.0)
    heading = pose.theta + half
    return Pose(
        pose.x + chord * math.cos(heading),
        pose.y + chord * math.sin(heading),
        math.remainder(pose.theta + rotation, math.tau),
    )

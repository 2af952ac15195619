"""A fleet with ideal sensing: the decision layer alone, for large studies.

Patrol, heading loop and gate are the agent's; bodies and contacts are the world's. Poses are true,
teammates are seen at their true positions (``IdealSight``), and no byte is encoded.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from drivers.p2os.model_choice import expected_model
from maps.map_folder import MapFolder
from maps.pose import Pose
from robot_agent.config import AgentConfig, RobotSettings
from robot_agent.motion.gate_settings import gate_limits
from tools.bench.bench_fault import BenchFault, BenchFaultError, FaultKind, check_robots, wrecks_of
from tools.bench.bench_result import bench_result, robot_figures
from tools.bench.ideal_obstacles import IdealObstacles
from tools.bench.ideal_robot import STEP_S, along_arc, make_ideal_robot
from tools.bench.ideal_sight import IdealSight
from tools.bench.perception_log import PerceptionLog
from tools.metrics.metrics import RobotRun
from tools.metrics.wreck import Wreck
from tools.simulation.start_poses import free_start_poses
from tools.simulation.truth.truth import load_truth
from tools.simulation.world import World

_STEP_WAY = 0.06  # m; upper bound of the motion of one step
_POSSIBLE = (FaultKind.DEAD, FaultKind.STUCK)


class IdealFleet:
    """A simulated world of robots with ideal sensing, under a virtual clock."""

    def __init__(
        self,
        folder: MapFolder,
        robots: int,
        seed: int,
        config: AgentConfig | None = None,
        starts: Sequence[Pose] | None = None,
        faults: Sequence[BenchFault] = (),
    ) -> None:
        """Place the robots, at the seeded random starts of ``Fleet`` unless given.

        Raises BenchFaultError for a fault of an unknown robot, or of devices.
        """
        assert folder.border is not None, "robots patrol a border"
        self.config = config = config or AgentConfig()
        rng = np.random.default_rng(seed)
        self.folder, self.seed, self.t = folder, seed, 0.0
        self.world = World(folder.map, rng, load_truth("ideal").noise)
        if starts is None:
            starts = free_start_poses(folder.map, folder.border, robots, rng)
        self.robots = [
            make_ideal_robot(self.world.add_body(start), _named(config, number, seed), folder)
            for number, start in enumerate(starts)
        ]
        self.faults = tuple(faults)
        _check_faults(self.faults, [robot.name for robot in self.robots])
        self._ahead = np.array([robot.body.outline.middle for robot in self.robots])
        self._sight = IdealSight(
            config.perception.detection_range,
            folder.map,
            len(self.robots),
            config.laser.field_of_view_deg,
        )
        self._closest = [math.inf] * len(self.robots)  # m to the nearest other robot
        self._obstacles = IdealObstacles(
            gate_limits(config.gate, expected_model(config.base)), folder.map, folder.border
        )

    def step(self) -> None:
        """Advance by STEP_S: motion, sensing, decisions."""
        self.t = round(self.t + STEP_S, 6)
        self._inject()
        self._move()
        teammates = self._sense()
        self._closest = self._sight.apart.min(axis=1).tolist()
        for index, robot in enumerate(self.robots):
            if not robot.dead:
                apart = self._sight.apart[index], self._closest[index]
                obstacles = self._obstacles.around(robot, *apart, self.robots)
                robot.decide(self.t, teammates[index], obstacles)

    def wrecks(self) -> list[Wreck]:
        """Return the robots that a fault has stopped permanently by now."""
        poses = {robot.name: robot.body.pose for robot in self.robots}
        return wrecks_of(self.faults, poses, self.t)

    def _inject(self) -> None:
        """Begin and end faults."""
        for robot in self.robots if self.faults else ():
            on = {f.kind for f in self.faults if f.robot == robot.name and f.holds(self.t)}
            robot.dead, robot.stuck = FaultKind.DEAD in on, FaultKind.STUCK in on

    def _move(self) -> None:
        """Move all robots; those near a wall or a body by the world, which checks contacts."""
        for index, robot in enumerate(self.robots):
            body, motion = robot.body, robot.roll(STEP_S)
            room = 2.0 * body.reach + 4.0 * _STEP_WAY
            if self._closest[index] > room and self._obstacles.is_clear_of_walls(robot, _STEP_WAY):
                body.pose = along_arc(body.pose, *motion)
            else:
                self.world.move(body, *motion)

    def _sense(self) -> list[tuple[float, float] | None]:
        poses = np.array([robot.body.pose for robot in self.robots]).T
        heading = np.array((np.cos(poses[2]), np.sin(poses[2])))
        speed = np.array([robot.v for robot in self.robots])
        base = poses[:2]
        return self._sight.look(self.t, base, heading, base + self._ahead * heading, speed)


def _named(config: AgentConfig, number: int, seed: int) -> AgentConfig:
    own = RobotSettings(
        name=f"robot{number + 1}", team=config.robot.team, seed=seed * 1000 + number
    )
    patrol = msgspec.structs.replace(config.patrol, common_secret=secret_of(config, seed))
    return msgspec.structs.replace(config, robot=own, patrol=patrol)


def secret_of(config: AgentConfig, seed: int) -> str:
    """Return the common secret of the team of a seed: each has its own; none if none is set."""
    secret = config.patrol.common_secret
    return f"{secret}/{seed}" if secret else ""


def _check_faults(faults: Sequence[BenchFault], names: list[str]) -> None:
    check_robots(faults, names)
    for fault in faults:
        if fault.kind not in _POSSIBLE:
            raise BenchFaultError(
                f"fault {fault.kind} of {fault.robot} is one of devices, which ideal sensing has "
                f"not: use {' or '.join(_POSSIBLE)}, or --sensing bytes"
            )


class IdealLog:
    """Samples the true poses and the decisions of an ideal fleet."""

    def __init__(self, fleet: IdealFleet) -> None:
        """Start an empty log of a fleet."""
        self._fleet = fleet
        self._times: list[float] = []
        self._places: list[list[tuple[float, float]]] = []
        self._actions: list[list[str]] = [[] for _ in fleet.robots]
        self._directions: list[list[int]] = [[] for _ in fleet.robots]

    def sample(self) -> None:
        """Append every robot's true pose and decision in force."""
        robots = self._fleet.robots
        self._times.append(self._fleet.t)
        self._places.append([robot.body.pose[:2] for robot in robots])
        for robot, actions, directions in zip(robots, self._actions, self._directions, strict=True):
            decision = None if robot.dead else robot.decision
            actions.append(decision.action.value if decision else "")
            directions.append(decision.direction if decision else 0)

    def runs(self) -> list[RobotRun]:
        """Return the samples, one run per robot."""
        t, places = np.array(self._times), _places(self._places, len(self._fleet.robots))
        return [
            RobotRun(
                name=robot.name,
                t=t,
                position=places[index],
                action=self._actions[index],
                direction=np.array(self._directions[index], dtype=np.int8),
            )
            for index, robot in enumerate(self._fleet.robots)
        ]


def _places(rows: list[list[tuple[float, float]]], robots: int) -> NDArray[np.float64]:
    """Return positions (robots, n, 2), m, as contiguous arrays."""
    return np.ascontiguousarray(np.array(rows).reshape(-1, robots, 2).swapaxes(0, 1))


def run_ideal_bench(
    fleet: IdealFleet,
    duration: float,
    progress: Callable[[float], None] = lambda _: None,
    log: IdealLog | None = None,
) -> dict[str, Any]:
    """Run a fleet for a duration (s, virtual); return the figures of ``bench --json``.

    log: the log that samples the run, for access beyond the figures; by default a new one.
    """
    started = time.perf_counter()
    log = log or IdealLog(fleet)
    while fleet.t < duration:
        fleet.step()
        log.sample()
        progress(fleet.t)
    assert fleet.folder.border is not None
    wall = time.perf_counter() - started
    return {
        "sensing": "ideal",
        "truth": "ideal",
        **bench_result(fleet, log.runs(), duration, wall),
        "strangers": 0,
        "each": [
            robot_figures(robot.name, fleet.world, robot.body.index) for robot in fleet.robots
        ],
        "perception": PerceptionLog(fleet.world, fleet.folder.border).figures(),  # empty
        "gate_stops": sum(robot.gate_stops for robot in fleet.robots),
    }

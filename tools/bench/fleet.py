"""A fleet in lockstep: emulated devices, the real agents, every byte encoded and decoded."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import msgspec
import numpy as np

from maps.map_folder import MapFolder
from maps.pose import Pose
from robot_agent.agent import Agent
from robot_agent.config import AgentConfig, MapSettings, RobotSettings
from robot_agent.pose.start_pose import StartPose
from tools.bench.bench_fault import BenchFault, FaultInjector, check_robots, wrecks_of
from tools.bench.bench_result import bench_result, robot_figures
from tools.bench.perception_log import PerceptionLog
from tools.bench.stand_log import StandLog
from tools.metrics.metrics import RobotRun
from tools.metrics.wreck import Wreck
from tools.simulation.emulated_camera import EmulatedCamera
from tools.simulation.lockstep import LockstepAgent, Observer
from tools.simulation.lockstep_camera import LockstepCamera
from tools.simulation.rig import RobotRig, make_rigs, outline_of, sense
from tools.simulation.start_poses import free_start_poses
from tools.simulation.stranger import make_strangers
from tools.simulation.tight_starts import tight_start_poses
from tools.simulation.true_world import make_world
from tools.simulation.truth.truth import Truth, load_truth

STEP_S = 0.02
SAMPLE_S = 0.1
STRANGERS_S = 0.05
"""Period of the strangers' steps, s."""


@dataclass(frozen=True)
class FleetRobot:
    """One robot of the fleet: its rig and its agent."""

    rig: RobotRig
    lockstep: LockstepAgent
    injector: FaultInjector | None = None
    camera: LockstepCamera | None = None

    @property
    def decides(self) -> bool:
        """Whether the agent is not dead and has made a decision."""
        dead = self.injector is not None and self.injector.agent_dead
        return not dead and self.agent.decision is not None

    @property
    def agent(self) -> Agent:
        """The robot's agent."""
        return self.lockstep.agent


class Fleet:
    """A simulated world of robots under a virtual clock."""

    def __init__(
        self,
        folder: MapFolder,
        robots: int,
        seed: int,
        config: AgentConfig | None = None,
        starts: list[Pose] | None = None,
        observer: Callable[[str, AgentConfig], Observer] | None = None,
        faults: Sequence[BenchFault] = (),
        *,
        strangers: int = 0,
        cameras: bool = False,
        truth: Truth | None = None,
        tight: bool = False,
    ) -> None:
        """Place the robots (at seeded random starts unless given) and power them.

        observer: makes a robot's recorder by its name. strangers: number of moving people and
        carts. cameras: whether the robots have cameras. truth: what the robots and
        the noise really are, by default the shipped ``plain``. tight: whether random starts are
        beside walls. Raises BenchFaultError for a fault of an unknown robot, StrangerError where
        there is no room for strangers, StartPoseError where there is none for the robots.
        """
        rng = np.random.default_rng(seed)
        self.folder = folder
        self.config = config or AgentConfig()
        self.truth = truth or load_truth("plain")
        self.seed = seed
        self.t = 0.0
        self.world = make_world(folder, rng, self.truth)
        if starts is None:
            assert folder.border is not None, "random starts lie near a border"
            outline, occupancy = outline_of(self.truth.robot), self.world.occupancy
            if tight:
                starts = tight_start_poses(occupancy, folder.border, robots, rng, outline)
            else:
                starts = free_start_poses(occupancy, folder.border, robots, rng, outline.reach)
        rigs = self._rigs = make_rigs(self.world, starts, self.t, self.truth)
        self.faults = tuple(faults)
        check_robots(self.faults, [rig.name for rig in rigs])
        self.robots: list[FleetRobot] = []
        for number, rig in enumerate(rigs):
            settings = _configure(self.config, folder, rig, seed * 1000 + number)
            own = [fault for fault in self.faults if fault.robot == rig.name]
            injector = FaultInjector(own, rig, folder, settings.robot.seed) if own else None
            devices = injector or rig
            camera = self._make_camera(rig, settings) if cameras else None
            lockstep = LockstepAgent(
                Agent(settings, folder, publishes=observer is not None),
                {"base": devices.base, "laser": devices.laser},
                observer(rig.name, settings) if observer else None,
                camera,
            )
            self.robots.append(FleetRobot(rig, lockstep, injector, camera))
        assert folder.border is not None or not strangers, "strangers walk near a border"
        self.strangers = (
            make_strangers(self.world, folder.border, strangers, seed, self.truth.people.leg)
            if folder.border
            else []
        )
        self._next_strangers = 0.0
        for robot in self.robots:
            robot.lockstep.start(self.t)

    def step(self) -> None:
        """Advance by STEP_S."""
        self.t = round(self.t + STEP_S, 6)
        if self.strangers and self.t >= self._next_strangers:
            self._next_strangers += STRANGERS_S
            for stranger in self.strangers:
                stranger.advance(STRANGERS_S)
        for robot in self.robots:
            if robot.injector:
                robot.injector.advance(self.t)
            robot.rig.move(self.t)
        sense(self._rigs, self.t)
        for robot in self.robots:
            if robot.camera:
                robot.camera.advance(self.t)
        for robot in self.robots:
            if robot.injector and robot.injector.agent_dead:
                robot.injector.discard_output(self.t)
            else:
                robot.lockstep.deliver(self.t)

    def _make_camera(self, rig: RobotRig, settings: AgentConfig) -> LockstepCamera:
        robot = rig.truth
        emulated = EmulatedCamera(self.world, rig.body, robot.camera, robot.band, self.seed)
        return LockstepCamera(emulated.picture_at, settings.camera, settings.perception.color)

    def shut_down(self) -> None:
        """Shut every agent down."""
        for robot in self.robots:
            robot.lockstep.shut_down(self.t)

    def wrecks(self) -> list[Wreck]:
        """Return the robots that a fault has stopped permanently by now."""
        poses = {robot.rig.name: robot.rig.body.pose for robot in self.robots}
        return wrecks_of(self.faults, poses, self.t)


def _configure(config: AgentConfig, folder: MapFolder, rig: RobotRig, seed: int) -> AgentConfig:
    """Return a robot's configuration: name, seed, map and approximate start pose."""
    start = rig.body.pose
    return msgspec.structs.replace(
        config,
        robot=RobotSettings(name=rig.name, team=config.robot.team, seed=seed),
        map=MapSettings(folder=folder.name, border=folder.border_name),
        start=StartPose(x=start.x, y=start.y, theta=start.theta),
    )


class FleetLog:
    """Samples the true poses and the decisions of a fleet."""

    def __init__(self, fleet: Fleet) -> None:
        """Start an empty log of a fleet."""
        self._fleet = fleet
        self._times: list[float] = []
        laser = fleet.robots[0].lockstep.agent.config.laser
        self._perception = PerceptionLog(fleet.world, fleet.folder.border, laser.field_of_view_deg)
        self._stands = {robot.rig.name: StandLog() for robot in fleet.robots}
        self._rows: dict[str, list[tuple[float, float, str, int]]] = {
            robot.rig.name: [] for robot in fleet.robots
        }

    def sample(self) -> None:
        """Append every robot's true pose and decision in force."""
        self._times.append(self._fleet.t)
        for robot in self._fleet.robots:
            decision = robot.agent.decision if robot.decides else None
            action, direction = (str(decision.action), decision.direction) if decision else ("", 0)
            pose = robot.rig.body.pose
            self._stands[robot.rig.name].sample(self._fleet.t, pose, robot.agent)
            if decision is not None:
                self._perception.sample(self._fleet.t, robot.rig.body, robot.agent)
            self._rows[robot.rig.name].append((pose.x, pose.y, action, direction))

    def perception(self) -> dict[str, Any]:
        """Return the figures of the robots' perception of each other and of strangers."""
        return self._perception.figures()

    def each(self) -> list[dict[str, Any]]:
        """Return each robot's first stand with a reason, what it said, and its contacts by kind."""
        return [
            robot_figures(rig.name, self._fleet.world, rig.body.index, self._stands[rig.name])
            for rig in (robot.rig for robot in self._fleet.robots)
        ]

    def runs(self) -> list[RobotRun]:
        """Return the samples, one run per robot."""
        t = np.array(self._times)
        return [
            RobotRun(
                name=name,
                t=t,
                position=np.array([row[:2] for row in rows]).reshape(-1, 2),
                action=[row[2] for row in rows],
                direction=np.array([row[3] for row in rows], dtype=np.int8),
            )
            for name, rows in self._rows.items()
        ]


def run_bench(
    fleet: Fleet,
    duration: float,
    progress: Callable[[float], None] = lambda _: None,
    log: FleetLog | None = None,
) -> dict[str, Any]:
    """Run a fleet for a duration (s, virtual) and return the figures of ``bench --json``.

    log: the log that samples the run, for access beyond the figures; by default a new one.
    """
    started = time.perf_counter()
    log = log or FleetLog(fleet)
    next_sample = fleet.t
    while fleet.t < duration:
        fleet.step()
        if fleet.t >= next_sample:
            log.sample()
            next_sample += SAMPLE_S
            progress(fleet.t)
    fleet.shut_down()
    wall = time.perf_counter() - started
    return {
        "sensing": "bytes",
        "truth": fleet.truth.name,
        **bench_result(fleet, log.runs(), duration, wall),
        "strangers": len(fleet.strangers),
        "each": log.each(),
        "perception": log.perception(),
        "gate_stops": sum(robot.agent.gate_stops for robot in fleet.robots),
    }

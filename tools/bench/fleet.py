"""Many robots in lockstep: emulated devices, the real agents, every byte encoded and decoded."""

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
from robot_agent.config import AgentConfig, RobotSettings, StartSettings
from tools.bench.bench_fault import BenchFault, FaultInjector, check_robots, fault_figures
from tools.bench.lockstep import LockstepAgent, Observer
from tools.bench.metrics import RobotRun, bench_figures
from tools.bench.perception_log import PerceptionLog
from tools.bench.rig import RobotRig, make_rigs, sense
from tools.bench.start_poses import free_start_poses
from tools.bench.world import World

STEP_S = 0.02
SAMPLE_S = 0.1


@dataclass(frozen=True)
class FleetRobot:
    """One robot of the fleet: its hardware and its mind."""

    rig: RobotRig
    lockstep: LockstepAgent
    injector: FaultInjector | None = None

    @property
    def decides(self) -> bool:
        """Whether the agent is there and has decided something."""
        dead = self.injector is not None and self.injector.agent_dead
        return not dead and self.agent.decision is not None

    @property
    def agent(self) -> Agent:
        """The robot's agent."""
        return self.lockstep.agent


class Fleet:
    """A world of robots under a virtual clock."""

    def __init__(
        self,
        folder: MapFolder,
        robots: int,
        seed: int,
        config: AgentConfig | None = None,
        starts: list[Pose] | None = None,
        observer: Callable[[str, AgentConfig], Observer] | None = None,
        faults: Sequence[BenchFault] = (),
    ) -> None:
        """Place the robots (at seeded random starts unless given) and power them.

        ``observer`` makes the recorder of the robot of that name. Raises BenchFaultError for a
        fault of a robot that is not there.
        """
        rng = np.random.default_rng(seed)
        self.folder = folder
        self.seed = seed
        self.t = 0.0
        self.world = World(folder.map, rng)
        if starts is None:
            assert folder.border is not None, "random starts lie near a border"
            starts = free_start_poses(folder.map, folder.border, robots, rng)
        rigs = self._rigs = make_rigs(self.world, starts, self.t)
        self.faults = tuple(faults)
        check_robots(self.faults, [rig.name for rig in rigs])
        self.robots: list[FleetRobot] = []
        for number, rig in enumerate(rigs):
            settings = _configure(config or AgentConfig(), rig, seed * 1000 + number)
            own = [fault for fault in self.faults if fault.robot == rig.name]
            injector = FaultInjector(own, rig, settings.robot.seed) if own else None
            devices = injector or rig
            lockstep = LockstepAgent(
                Agent(settings, folder, publishes=observer is not None),
                {"base": devices.base, "laser": devices.laser},
                observer(rig.name, settings) if observer else None,
            )
            self.robots.append(FleetRobot(rig, lockstep, injector))
        for robot in self.robots:
            robot.lockstep.start(self.t)

    def step(self) -> None:
        """Let STEP_S pass."""
        self.t = round(self.t + STEP_S, 6)
        for robot in self.robots:
            if robot.injector:
                robot.injector.advance(self.t)
            robot.rig.move(self.t)
        sense(self._rigs, self.t)
        for robot in self.robots:
            if robot.injector and robot.injector.agent_dead:
                robot.injector.lose_output(self.t)
            else:
                robot.lockstep.deliver(self.t)

    def shut_down(self) -> None:
        """End every agent in good order."""
        for robot in self.robots:
            robot.lockstep.shut_down(self.t)

    def wrecks(self) -> list[tuple[float, float]]:
        """Return where robots stand, (x, y) m, that a fault has stopped for good by now."""
        stopped = {
            fault.robot for fault in self.faults if fault.makes_wreck and fault.holds(self.t)
        }
        bodies = [robot.rig.body for robot in self.robots if robot.rig.name in stopped]
        return [(body.pose.x, body.pose.y) for body in bodies]


def _configure(config: AgentConfig, rig: RobotRig, seed: int) -> AgentConfig:
    """Give a robot its name, its seed and about where it is."""
    start = rig.body.pose
    return msgspec.structs.replace(
        config,
        robot=RobotSettings(name=rig.name, team=config.robot.team, seed=seed),
        start=StartSettings(x=start.x, y=start.y, theta=start.theta),
    )


class FleetLog:
    """Samples the truth and the decisions of a fleet."""

    def __init__(self, fleet: Fleet) -> None:
        """Nothing is sampled before the first ``sample``."""
        self._fleet = fleet
        self._times: list[float] = []
        self._perception = PerceptionLog(fleet.world)
        self._rows: dict[str, list[tuple[float, float, str, int]]] = {
            robot.rig.name: [] for robot in fleet.robots
        }

    def sample(self) -> None:
        """Take down where every robot truly is and what it has decided."""
        self._times.append(self._fleet.t)
        for robot in self._fleet.robots:
            decision = robot.agent.decision if robot.decides else None
            action, direction = (str(decision.action), decision.direction) if decision else ("", 0)
            pose = robot.rig.body.pose
            if decision is not None:
                self._perception.sample(self._fleet.t, robot.rig.body, robot.agent.tracker.tracks)
            self._rows[robot.rig.name].append((pose.x, pose.y, action, direction))

    def perception(self) -> dict[str, Any]:
        """Return how well the robots saw each other."""
        return self._perception.figures()

    def runs(self) -> list[RobotRun]:
        """Return what was sampled, one run per robot."""
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

    log: what samples the run, for one who wants to see more of it than the figures.
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
    assert fleet.folder.border is not None
    return {
        "sensing": "bytes",
        "robots": len(fleet.robots),
        "seed": fleet.seed,
        "duration_s": duration,
        "wall_s": time.perf_counter() - started,
        "faults": fault_figures(fleet.faults),
        **bench_figures(fleet.folder.border, log.runs(), fleet.world.contacts, fleet.wrecks()),
        "perception": log.perception(),
        "gate_stops": sum(robot.agent.gate_stops for robot in fleet.robots),
    }

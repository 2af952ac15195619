"""Runs emulated robots as processes: one world, one unmodified agent per robot, one operator."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Self

import msgspec

from maps.pose import Pose
from robot_agent.config import AgentConfig, MapSettings, RobotSettings, format_config
from robot_agent.pose.start_pose import StartPose
from tools.deploy.child_program import environment, program
from tools.monitor.monitor import Monitor, MonitorOptions, until
from tools.monitor.site import Site
from tools.monitor.text_view import show_team
from tools.progress import progress_line

POLL_S = 0.2
STOP_S = 5.0
"""Time for a process to end after SIGTERM before it is killed."""


class DemoError(ValueError):
    """The demo could not be started."""


@dataclass(frozen=True)
class EmulatedRobot:
    """Ports and start of one emulated robot, as the world process prints them."""

    name: str
    base_url: str
    laser_url: str
    camera_url: str
    """Empty if the robot has no camera."""
    start: Pose
    """True starting pose, map_from_base."""


@dataclass(frozen=True)
class DemoOptions:
    """Options of a demo run."""

    map_folder: Path
    border: str
    robots: int
    seed: int
    operator: str
    """Zenoh endpoint the agents connect to."""
    record: Path
    """Folder for recordings, configurations and true positions; made if missing."""
    strangers: int = 0
    """Number of moving people and carts."""
    cameras: bool = False
    """Whether the robots have cameras."""
    truth: str = "plain"
    """Name or file of what the robots and their world really are."""
    config: AgentConfig = field(default_factory=AgentConfig)
    """Common configuration; name, seed, map, start, ports and operator are set per robot."""


class Demo:
    """The processes of a demo: stopped in order, agents before the world, on every way out."""

    def __init__(self, options: DemoOptions) -> None:
        """Store the options; starts nothing, ``running()`` does."""
        self.options = options
        self.robots: list[EmulatedRobot] = []
        self.exit_statuses: dict[str, int] = {}
        self._agents: dict[str, subprocess.Popen[bytes]] = {}
        self._world: subprocess.Popen[str] | None = None

    @property
    def truth_path(self) -> Path:
        """File the world process writes the true positions to, as JSON lines."""
        return self.options.record / "truth.jsonl"

    def recording_path(self, robot: str) -> Path:
        """Return the file of a robot's recording."""
        return self.options.record / f"{robot}.mcap"

    @contextmanager
    def running(self) -> Iterator[Self]:
        """Start the world, then one agent per robot; stop everything on every way out.

        Raises DemoError if the world process does not start.
        """
        self.options.record.mkdir(parents=True, exist_ok=True)
        try:
            self._start_world()
            for number, robot in enumerate(self.robots):
                self._start_agent(robot, self.options.seed + number)
            yield self
        finally:
            self.stop()

    def watch(
        self, duration: float | None, site: Site, *, http: str | None, headless: bool
    ) -> bool:
        """Run the demo with its monitor until the duration (s) is over or Ctrl-C.

        The duration counts from when every agent records: imports take long on a slow computer.
        Returns whether every process was still running at the end; raises KeyboardInterrupt for a
        Ctrl-C before that, DemoError when the demo cannot be started, WebError when the page cannot
        be served at ``http``.
        """
        with (
            closing(Monitor(MonitorOptions(self.options.operator, http, site))) as monitor,
            self.running(),
        ):
            if monitor.url:
                print(f"patrol demo: the team is shown at {monitor.url}", file=sys.stderr)
            while self.alive() and not self._recording():
                time.sleep(POLL_S)
            try:
                going_on = until(duration)
                if headless:
                    self._wait_while(going_on)
                else:
                    show_team(monitor.watch, lambda: self.alive() and going_on())
            except KeyboardInterrupt:
                print("patrol demo: stopping the robots", file=sys.stderr)
            return self.alive()

    def _recording(self) -> bool:
        return all(self.recording_path(robot.name).exists() for robot in self.robots)

    def _wait_while(self, going_on: Callable[[], bool]) -> None:
        with progress_line("demo", None, "s") as progress:
            started = time.monotonic()
            while self.alive() and going_on():
                time.sleep(POLL_S)
                progress(time.monotonic() - started)

    def alive(self) -> bool:
        """Return whether every process is running."""
        processes = [self._world, *self._agents.values()]
        return all(process is not None and process.poll() is None for process in processes)

    def agent_pids(self) -> list[int]:
        """Return the process ids of the agents, in the robots' order."""
        return [process.pid for process in self._agents.values()]

    def stop(self) -> None:
        """End the agents, which stop their robots, then the world; fill ``exit_statuses``."""
        for process in self._agents.values():
            if process.poll() is None:
                process.send_signal(signal.SIGTERM)
        for name, process in self._agents.items():
            self.exit_statuses[name] = _wait(process)
        if self._world is not None:
            self._world.send_signal(signal.SIGTERM)
            self.exit_statuses["world"] = _wait(self._world)
            assert self._world.stdout is not None
            self._world.stdout.close()
            self._world = None
        self._agents.clear()

    def _start_world(self) -> None:
        options = self.options
        self._world = subprocess.Popen(
            [
                *program("tools.demo.world_server", str(options.map_folder)),
                *("--border", options.border, "--robots", str(options.robots)),
                *("--seed", str(options.seed), "--poses", str(self.truth_path)),
                *("--truth", options.truth),
                *("--strangers", str(options.strangers)),
                *(("--cameras",) if options.cameras else ()),
            ],
            env=environment(),
            stdout=subprocess.PIPE,
            text=True,
            start_new_session=True,  # Ctrl-C must not reach it: agents are stopped before it
        )
        assert self._world.stdout is not None
        line = self._world.stdout.readline()
        if not line:
            raise DemoError("the world process did not start; its messages are above")
        self.robots = [
            EmulatedRobot(
                robot["name"],
                robot["base"],
                robot["laser"],
                robot["camera"],
                Pose(*robot["start"]),
            )
            for robot in json.loads(line)
        ]

    def _start_agent(self, robot: EmulatedRobot, seed: int) -> None:
        config_path = self.options.record / f"{robot.name}.toml"
        config_path.write_text(format_config(self._configure(robot, seed)))
        self._agents[robot.name] = subprocess.Popen(
            [
                *program("tools.cli", "agent", str(config_path)),
                *("--record", str(self.recording_path(robot.name))),
            ],
            env=environment(),
            start_new_session=True,
        )

    def _configure(self, robot: EmulatedRobot, seed: int) -> AgentConfig:
        """Return a robot's configuration: the common one with its identity, ports and start."""
        common = self.options.config
        return msgspec.structs.replace(
            common,
            robot=RobotSettings(name=robot.name, team="demo", seed=seed),
            map=MapSettings(
                folder=str(self.options.map_folder.resolve()), border=self.options.border
            ),
            start=StartPose(x=robot.start.x, y=robot.start.y, theta=robot.start.theta),
            base=msgspec.structs.replace(common.base, url=robot.base_url),
            laser=msgspec.structs.replace(common.laser, url=robot.laser_url),
            camera=msgspec.structs.replace(common.camera, url=robot.camera_url),
            telemetry=msgspec.structs.replace(common.telemetry, operator=self.options.operator),
        )


def _wait(process: subprocess.Popen[bytes] | subprocess.Popen[str]) -> int:
    """Return a process's exit status; kill it if it does not end within ``STOP_S``."""
    try:
        return process.wait(STOP_S)
    except subprocess.TimeoutExpired:
        process.kill()
        return process.wait()

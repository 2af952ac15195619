"""Test stage of the campaign: a small world, fault-injecting lines, the shipped agent process."""

from __future__ import annotations

import math
import resource
import shutil
import signal
import subprocess
import threading
import time
from collections import deque
from collections.abc import Callable
from contextlib import ExitStack, closing
from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np

from drivers.emulation.fault_plan import FaultPlan
from drivers.emulation.line_faults import LineFaults
from drivers.p2os.emulator.base import FACTORY_WATCHDOG
from maps.map_folder import load_map_folder
from maps.occupancy_map import FREE, OCCUPIED, OccupancyMap, save_map
from maps.pose import Pose
from robot_agent.config import AgentConfig, MapSettings, RobotSettings, format_config
from robot_agent.pose.pose_memory import MemorySettings
from robot_agent.pose.start_pose import StartPose
from tools.campaign.cpu_limit import CpuLimit
from tools.campaign.flood import Flood
from tools.campaign.journal_pipe import JournalPipe
from tools.campaign.loop_disk import LoopDisk
from tools.campaign.order_tap import OrderTap
from tools.campaign.service_watch import ServiceWatch
from tools.deploy.child_program import environment, program
from tools.monitor.endpoint import free_endpoint
from tools.monitor.operator import Operator
from tools.simulation.cable import Cable
from tools.simulation.emulated_camera import CameraServer, EmulatedCamera
from tools.simulation.real_time_rig import RealTimeRig
from tools.simulation.rig import RobotRig
from tools.simulation.world import World

START = Pose(4.5, 1.6, math.pi)
"""Start pose beside the border of the room, heading along it."""
STOP_S = 5.0
"""Time for the agent to shut down before it is killed, s."""

_ROOM = (8.0, 6.0)  # m
_RESOLUTION = 0.05  # m
_BOXES = ((0.1, 0.1, 0.6, 0.9), (6.9, 4.9, 7.9, 5.5), (3.4, 5.5, 4.2, 5.9), (3.8, 2.8, 4.4, 3.2))
_BORDER = """\
closed = true
corner_radius = 1.0
vertices = [[1.5, 4.5], [6.5, 4.5], [6.5, 1.5], [1.5, 1.5]]
"""


def make_room(folder: Path) -> None:
    """Write a map folder: a room of 8 by 6 m with a few boxes, and a border round it."""
    cells = np.full((round(_ROOM[1] / _RESOLUTION), round(_ROOM[0] / _RESOLUTION)), FREE, np.uint8)
    cells[:2], cells[-2:], cells[:, :2], cells[:, -2:] = (OCCUPIED,) * 4
    for left, bottom, right, top in _BOXES:
        x0, y0, x1, y1 = (round(edge / _RESOLUTION) for edge in (left, bottom, right, top))
        cells[y0:y1, x0:x1] = OCCUPIED
    save_map(OccupancyMap(cells, _RESOLUTION, Pose(0.0, 0.0, 0.0)), folder)
    (folder / "border.toml").write_text(_BORDER)


@dataclass(frozen=True, slots=True)
class Moment:
    """The true state of the robot at one time."""

    t: float
    """Monotonic clock of this host, s."""
    v: float
    """Speed of the wheels, m/s."""
    w: float
    """Turn rate of the wheels, rad/s."""
    order: str
    """Source of an order to stand: agent, watchdog, controller; empty: none."""
    contacts: int

    @property
    def moving(self) -> bool:
        """Whether the robot moves faster than a threshold."""
        return abs(self.v) > 0.05 or abs(self.w) > 0.1

    @property
    def standing(self) -> bool:
        """Whether the wheels are at rest."""
        return abs(self.v) < 0.005 and abs(self.w) < 0.01


class AgentStage:
    """Simulates one robot in real time; the agent is a process started by ``start_agent``.

    ``step`` advances the world; ``close`` ends everything.
    """

    def __init__(
        self,
        folder: Path,
        seed: int = 1,
        operator: str | None = None,
        watchdog: float = FACTORY_WATCHDOG,
    ) -> None:
        """Build world and lines in ``folder``, which also holds configurations and recordings.

        operator: endpoint to which the agent connects; empty for none; None for a free one, at
        which ``start_operator`` starts an operator. watchdog: value in the base's FLASH, s.
        """
        self.folder = folder
        self.recordings: list[Path] = []
        self._endpoint = free_endpoint() if operator is None else operator
        self._operator: Operator | None = None
        self._seed = seed
        self._agent: subprocess.Popen[bytes] | None = None
        self._scheduled: deque[tuple[float, Callable[[], None]]] = deque()
        self._flooders = ExitStack()
        self.sabotage = ""
        """What the agent's process is sabotaged in at SIGUSR1, if it is; see sabotaged_agent."""
        self.trace: list[Moment] = []
        """The state after every step so far."""
        self.ends: list[float] = []
        """End of each agent's process, s."""
        make_room(folder / "room")
        self._content = load_map_folder(folder / "room")
        rng = np.random.default_rng(seed)
        self.world = World(self._content.map, rng)
        self.rig = RobotRig(
            "robot1",
            self.world,
            self.world.add_body(START),
            time.monotonic(),
            watchdog=watchdog,
        )
        self.tap = OrderTap(self.rig.base)
        self.base_line = LineFaults(self.tap, FaultPlan(), rng)
        self.laser_line = LineFaults(self.rig.laser, FaultPlan(), rng)
        self.base_cable = Cable(self.base_line, folder / "base")
        self.laser_cable = Cable(self.laser_line, folder / "laser")
        self._camera: CameraServer | None = None
        self.service = ServiceWatch(folder)
        self.disk: LoopDisk | None = None
        """Where recordings go, if it is not ``folder``; made by ``mount_disk``."""
        self.pose_file: Path | None = None
        """The file of the pose memory of the agents to come, None for none."""
        self.journal: JournalPipe | None = None
        """Where the agents' standard error goes, if it is not to a file each."""
        self._real_time = RealTimeRig(self.rig, (self.base_cable, self.laser_cable))

    def close(self) -> None:
        """Shut the agent down, then everything else."""
        self.end_agent()
        self.stop_operator()
        self._flooders.close()
        self.base_cable.pull()
        self.laser_cable.pull()
        if self._camera is not None:
            self._camera.close()
        if self.journal is not None:
            self.journal.close()
        self.service.close()
        if self.disk is not None:
            self.recordings = [Path(shutil.copy(each, self.folder)) for each in self.recordings]
            self.disk.close()

    def mount_disk(self) -> None:
        """Record to a disk of its own from the next agent on; raises NotHereError."""
        self.disk = LoopDisk(self.folder)

    def mount_camera(self) -> None:
        """Add a camera; the next agent started is configured for it."""
        self._camera = CameraServer(EmulatedCamera(self.world, self.rig.body).picture_at)

    def step(self) -> Moment:
        """Simulate one step in real time; return the state after it."""
        t = self._real_time.step()
        self.service.step(t)
        if self._camera is not None:
            self._camera.pump(t)
        while self._scheduled and self._scheduled[0][0] <= t:
            self._scheduled.popleft()[1]()
        if self._agent is not None and self._agent.poll() is not None:
            self._log_end(t)
        v, w = self.rig.base.velocity
        moment = Moment(t, v, w, self._order(), self.world.contacts)
        self.trace.append(moment)
        return moment

    def _order(self) -> str:
        base = self.rig.base
        if base.watchdog_expired:
            return "watchdog"
        if self.tap.is_standing:
            return "agent"
        return "" if base.motion_permitted else "controller"

    def later(self, *actions: tuple[float, Callable[[], None]]) -> None:
        """Schedule (delay in s, action) pairs; ``step`` calls the actions when due, in order."""
        now = time.monotonic()
        self._scheduled.extend((now + delay, action) for delay, action in actions)

    def press_motors_twice(self) -> None:
        """Press the MOTORS button twice, a second apart, as a person does who clears a hold."""
        self.rig.base.press_motors_button()
        self.later((1.0, self.rig.base.press_motors_button))

    @property
    def off_border(self) -> float:
        """True distance of the robot from the border, m."""
        pose = self.rig.body.pose
        assert self._content.border is not None
        return self._content.border.project(pose.x, pose.y).distance

    def limit_agent(self, what: int, limit: int) -> None:
        """Set a resource limit (``resource.RLIMIT_*``) of the agent's process; -1 for no limit."""
        if self._agent is not None:
            resource.prlimit(self._agent.pid, what, (limit, resource.RLIM_INFINITY))

    def _log_end(self, t: float) -> None:
        """Store the end of the present agent's process, once."""
        if len(self.ends) < len(self.recordings):
            self.ends.append(t)

    def start_agent(self, limit: CpuLimit | None = None, *, elsewhere: bool = False) -> None:
        """Start an agent process with the robot's true pose as its start; end an earlier one.

        limit: holds it to a share of a core. elsewhere: configures the map of another place.
        """
        self.end_agent()
        number = len(self.recordings) + 1
        config = self.folder / f"robot{number}.toml"
        config.write_text(format_config(self._configure(elsewhere=elsewhere)))
        recordings = self.folder if self.disk is None else self.disk.folder
        self.recordings.append(recordings / f"robot{number}.mcap")
        with (self.folder / f"robot{number}.log").open("wb") as log:
            self._agent = subprocess.Popen(
                [
                    *program(*self._program(), "agent", str(config)),
                    *("--record", str(self.recordings[-1])),
                ],
                env={**environment(), **self.service.environment},
                start_new_session=True,
                stderr=log if self.journal is None else self.journal.end,
            )
        if limit is not None:
            limit.hold(self._agent.pid)

    def _program(self) -> tuple[str, ...]:
        if self.sabotage:
            return ("tools.campaign.sabotaged_agent", self.sabotage)
        return ("tools.cli",)

    def flood(self) -> None:
        """Listen at the operator's endpoint and send garbage as fast as the line takes it."""
        self._flooders.enter_context(closing(Flood(self._endpoint)))

    def end_flood(self) -> None:
        """End the flood."""
        self._step_during(self._flooders.close)

    def start_operator(self) -> None:
        """Start an operator at the agent's endpoint."""
        self._step_during(self._open_operator)

    def stop_operator(self) -> None:
        """Stop the operator."""
        if self._operator is not None:
            self._step_during(self._operator.close)
            self._operator = None

    def _open_operator(self) -> None:
        self._operator = Operator(self._endpoint)

    def _step_during(self, work: Callable[[], None]) -> None:
        """Run ``work`` on a thread and step the world until it has ended."""
        worker = threading.Thread(target=work)
        worker.start()
        while worker.is_alive():
            self.step()

    @property
    def agent_pid(self) -> int:
        """Process of the present agent."""
        assert self._agent is not None
        return self._agent.pid

    def agent_log(self) -> str:
        """Return the standard error of all agents so far."""
        return " | ".join(path.read_text().strip() for path in sorted(self.folder.glob("*.log")))

    def signal_agent(self, number: signal.Signals) -> None:
        """Send a signal to the agent process."""
        assert self._agent is not None
        self._agent.send_signal(number)

    def end_agent(self) -> None:
        """Shut the agent down while the world goes on; kill it if it does not end in time."""
        if self._agent is None:
            return
        agent, self._agent = self._agent, None
        agent.send_signal(signal.SIGCONT)
        agent.terminate()
        give_up = time.monotonic() + STOP_S
        while agent.poll() is None and time.monotonic() < give_up:
            self.step()
        agent.kill()
        agent.wait()
        self._log_end(time.monotonic())

    def _configure(self, *, elsewhere: bool) -> AgentConfig:
        """Return the shipped defaults with the robot's ports and start pose."""
        defaults = AgentConfig()
        pose = self.rig.body.pose
        room = "paper_lab" if elsewhere else str((self.folder / "room").resolve())
        return AgentConfig(
            robot=RobotSettings(name="robot1", team="faults", seed=self._seed),
            map=MapSettings(folder=room),
            start=StartPose(x=pose.x, y=pose.y, theta=pose.theta),
            base=msgspec.structs.replace(defaults.base, url=str(self.base_cable.path)),
            laser=msgspec.structs.replace(defaults.laser, url=str(self.laser_cable.path)),
            camera=msgspec.structs.replace(
                defaults.camera, url="" if self._camera is None else self._camera.url
            ),
            memory=MemorySettings(file="" if self.pose_file is None else str(self.pose_file)),
            telemetry=msgspec.structs.replace(defaults.telemetry, operator=self._endpoint),
        )

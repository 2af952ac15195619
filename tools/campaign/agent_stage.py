"""One patrolling robot to do harm to: a small world, faulty lines, the shipped agent process."""

from __future__ import annotations

import math
import resource
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
from robot_agent.pose.start_pose import StartPose
from tools.campaign.cpu_limit import CpuLimit
from tools.campaign.flood import Flood
from tools.campaign.order_tap import OrderTap
from tools.deploy.child_program import environment, program
from tools.monitor.endpoint import free_endpoint
from tools.monitor.operator import Operator
from tools.simulation.cable import Cable
from tools.simulation.emulated_camera import CameraServer, EmulatedCamera
from tools.simulation.real_time_rig import RealTimeRig
from tools.simulation.rig import RobotRig
from tools.simulation.world import World

START = Pose(4.5, 1.6, math.pi)
"""Beside the border of the room, heading along it."""
STOP_S = 5.0
"""How long the agent may take to end in good order before it is killed."""

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
    """What is true of the robot at one time."""

    t: float
    """s, on this host's monotonic clock."""
    v: float
    """m/s, of the wheels."""
    w: float
    """rad/s"""
    order: str
    """Who has ordered the robot to stand: agent, watchdog, controller; empty: nobody."""
    contacts: int

    @property
    def moving(self) -> bool:
        """Whether the robot moves in earnest."""
        return abs(self.v) > 0.05 or abs(self.w) > 0.1

    @property
    def standing(self) -> bool:
        """Whether the wheels are at rest."""
        return abs(self.v) < 0.005 and abs(self.w) < 0.01


class AgentStage:
    """The world steps in ``step``; the agent is a process, started by ``start_agent``.

    Everything is there until ``close``.
    """

    def __init__(
        self,
        folder: Path,
        seed: int = 1,
        operator: str | None = None,
        watchdog: float = FACTORY_WATCHDOG,
    ) -> None:
        """Build world and lines in a folder of their own, to which configuration and recordings
        go too. The agent dials an operator who is absent until ``seat_operator``, or the endpoint
        of another; empty: nobody. watchdog: s, what is set in the base's FLASH."""
        self.folder = folder
        self.recordings: list[Path] = []
        self._endpoint = free_endpoint() if operator is None else operator
        self._operator: Operator | None = None
        self._seed = seed
        self._agent: subprocess.Popen[bytes] | None = None
        self._to_do: deque[tuple[float, Callable[[], None]]] = deque()
        self._flooders = ExitStack()
        self.traitor = ""
        """What the agent's process is sabotaged in at SIGUSR1, if it is; see sabotaged_agent."""
        self.trace: list[Moment] = []
        """All that has been true so far, at every step."""
        self.ends: list[float] = []
        """When each agent's process had ended, s."""
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
        self._real_time = RealTimeRig(self.rig, (self.base_cable, self.laser_cable))

    def close(self) -> None:
        """End the agent in good order, then all around it."""
        self.end_agent()
        self.dismiss_operator()
        self._flooders.close()
        self.base_cable.pull()
        self.laser_cable.pull()
        if self._camera is not None:
            self._camera.close()

    def mount_camera(self) -> None:
        """Give the robot a camera, which the next agent is told of."""
        self._camera = CameraServer(EmulatedCamera(self.world, self.rig.body).picture_at)

    def step(self) -> Moment:
        """Let one step of real time pass; return what is true after it."""
        t = self._real_time.step()
        if self._camera is not None:
            self._camera.pump(t)
        while self._to_do and self._to_do[0][0] <= t:
            self._to_do.popleft()[1]()
        if self._agent is not None and self._agent.poll() is not None:
            self._note_end(t)
        v, w = self.rig.base.velocity
        moment = Moment(t, v, w, self._order(), self.world.contacts)
        self.trace.append(moment)
        return moment

    def _order(self) -> str:
        base = self.rig.base
        if base.watchdog_expired:
            return "watchdog"
        if self.tap.told_to_stand:
            return "agent"
        return "" if base.motion_permitted else "controller"

    def later(self, *actions: tuple[float, Callable[[], None]]) -> None:
        """Do things after so many s each, in this order, as the steps go on."""
        now = time.monotonic()
        self._to_do.extend((now + delay, action) for delay, action in actions)

    def look_after(self) -> None:
        """Let a person look at the robot: motors off and on again at the robot, a second apart."""
        self.rig.base.press_motors_button()
        self.later((1.0, self.rig.base.press_motors_button))

    @property
    def off_border(self) -> float:
        """How far the robot truly is from the border, m."""
        pose = self.rig.body.pose
        assert self._content.border is not None
        return self._content.border.project(pose.x, pose.y).distance

    def limit_agent(self, what: int, most: int) -> None:
        """Limit a resource of the agent's process, as the system does; -1 for no limit."""
        if self._agent is not None:
            resource.prlimit(self._agent.pid, what, (most, resource.RLIM_INFINITY))

    def _note_end(self, t: float) -> None:
        """Take down when the present agent's process has ended."""
        if len(self.ends) < len(self.recordings):
            self.ends.append(t)

    def start_agent(self, limit: CpuLimit | None = None, *, elsewhere: bool = False) -> None:
        """Start an agent process, told where the robot truly stands; an earlier one is ended.

        ``limit``: holds it to a share of a core. ``elsewhere``: with the map of another place.
        """
        self.end_agent()
        number = len(self.recordings) + 1
        config = self.folder / f"robot{number}.toml"
        config.write_text(format_config(self._configure(elsewhere=elsewhere)))
        self.recordings.append(self.folder / f"robot{number}.mcap")
        with (self.folder / f"robot{number}.log").open("wb") as log:
            self._agent = subprocess.Popen(
                [
                    *program(*self._program(), "agent", str(config)),
                    *("--record", str(self.recordings[-1])),
                ],
                env=environment(),
                start_new_session=True,
                stderr=log,
            )
        if limit is not None:
            limit.hold(self._agent.pid)

    def _program(self) -> tuple[str, ...]:
        if self.traitor:
            return ("tools.campaign.sabotaged_agent", self.traitor)
        return ("tools.cli",)

    def flood(self) -> None:
        """Let the operator's place be taken by one who sends garbage as fast as the line takes."""
        self._flooders.enter_context(closing(Flood(self._endpoint)))

    def end_flood(self) -> None:
        """Send the flooder away."""
        self._meanwhile(self._flooders.close)

    def seat_operator(self) -> None:
        """Let the operator's machine listen where the agent dials."""
        self._meanwhile(self._make_operator)

    def dismiss_operator(self) -> None:
        """Take the operator's machine off the network."""
        if self._operator is not None:
            self._meanwhile(self._operator.close)
            self._operator = None

    def _make_operator(self) -> None:
        self._operator = Operator(self._endpoint)

    def _meanwhile(self, work: Callable[[], None]) -> None:
        """Do something that takes its time while the world goes on."""
        worker = threading.Thread(target=work)
        worker.start()
        while worker.is_alive():
            self.step()

    def agent_log(self) -> str:
        """Return what the agents have said so far."""
        return " | ".join(path.read_text().strip() for path in sorted(self.folder.glob("*.log")))

    def signal_agent(self, number: signal.Signals) -> None:
        """Send the agent process a signal."""
        assert self._agent is not None
        self._agent.send_signal(number)

    def end_agent(self) -> None:
        """End the agent in good order, the world going on meanwhile; kill it when it does not."""
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
        self._note_end(time.monotonic())

    def _configure(self, *, elsewhere: bool) -> AgentConfig:
        """Return the shipped defaults with the robot's ports, and where it is."""
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
            telemetry=msgspec.structs.replace(defaults.telemetry, operator=self._endpoint),
        )

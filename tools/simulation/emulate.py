"""One emulated robot in a map, for any client of a Pioneer's base and of its laser."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import msgspec
import numpy as np

from drivers.emulation.fault_plan import parse_faults
from drivers.emulation.line_faults import LineFaults
from drivers.emulation.port import EmulatedDevice, PtyPort, TcpPort
from maps.map_folder import MapFolder
from maps.pose import Pose
from tools.simulation.base_options import BaseOptions
from tools.simulation.emulate_error import EmulateError
from tools.simulation.emulated_camera import CameraServer, EmulatedCamera
from tools.simulation.laser_start import parse_laser_start
from tools.simulation.real_time_rig import Pumped, RealTimeRig
from tools.simulation.rig import make_rig, outline_of
from tools.simulation.robot_body import RobotBody
from tools.simulation.start_poses import free_start_poses
from tools.simulation.true_world import make_world
from tools.simulation.truth.truth import Truth, load_truth
from tools.simulation.world import World


@dataclass(frozen=True, kw_only=True)
class EmulateOptions:
    """What to emulate, and at which ports."""

    truth: Truth = field(default_factory=lambda: load_truth("plain"))
    """What the robot and its world really are."""
    p2os: str = "pty"
    """``pty`` or ``tcp:PORT``; port 0 takes any free one."""
    lms200: str = "pty"
    lms1xx: str = ""
    """``tcp:PORT``: the robot has an LMS 111 there in place of an LMS 200; empty: as its truth."""
    p2os_faults: str = ""
    """Faults of the base's line, in the syntax of ``parse_faults``."""
    lms200_faults: str = ""
    lms200_start: str = ""
    """How the laser is found, in the syntax of ``parse_laser_start``."""
    lms1xx_faults: str = ""
    camera: int | None = None
    """TCP port of an MJPEG stream; 0 takes any free one, None serves none."""
    pose: Pose | None = None
    """True starting pose, map_from_base; None chooses a free place near the border."""
    base: BaseOptions = field(default_factory=BaseOptions)
    """How the base is, where not as the truth says."""
    seed: int = 1


class Emulation:
    """An emulated robot served on its ports until ``close``.

    Raises EmulateError, FaultSpecError or LaserStartError when it cannot be set up.
    """

    def __init__(self, folder: MapFolder, options: EmulateOptions) -> None:
        rng = np.random.default_rng(options.seed)
        world = make_world(folder, rng, options.truth)
        reach = outline_of(options.truth.robot).reach
        pose = options.pose or _free_pose(folder, world, rng, reach)
        robot = options.base.applied(options.truth.drawn(rng.spawn(1)[0]).robot)
        if options.lms1xx:
            scanner = msgspec.structs.replace(robot.laser, kind="lms1xx")
            robot = msgspec.structs.replace(robot, laser=scanner)
        laser_start = replace(
            parse_laser_start(options.lms200_start), paced=not options.lms200.startswith("tcp:")
        )
        if options.lms200_start and robot.laser.kind != "lms200":
            raise EmulateError("--lms200-start: this robot has no LMS 200; leave it out")
        self._base = options.base
        self._started_at = time.monotonic()
        try:
            self.rig = make_rig(
                *("Emulated", world, pose, self._started_at, robot),
                baud=options.base.baud,
                watchdog=options.base.watchdog,
                laser_start=laser_start,
            )
        except ValueError as error:
            raise EmulateError(f"--pose: {error}") from error
        options.base.plug_in(self.rig.base)
        self.urls: dict[str, str] = {}
        with ExitStack() as stack:
            names = Path(stack.enter_context(TemporaryDirectory(prefix="patrol-emulate-")))
            base = LineFaults(self.rig.base, parse_faults(options.p2os_faults), rng.spawn(1)[0])
            base.on_reset = lambda t: self.rig.base.reset(t, notify=False)  # as P2OS
            kind = robot.laser.kind
            faults, port_of_laser = options.lms200_faults, options.lms200
            if kind == "lms1xx":
                faults, port_of_laser = options.lms1xx_faults, options.lms1xx or "tcp:0"
                if port_of_laser == "pty":
                    raise EmulateError("--lms1xx pty: it is on a network; use e.g. tcp:2111")
            laser = LineFaults(self.rig.laser, parse_faults(faults), rng.spawn(1)[0])
            laser.on_reset = self.rig.laser.power_on
            ports: list[Pumped] = []
            for name, place, line in (
                ("p2os", options.p2os, base),
                (kind, port_of_laser, laser),
            ):
                port = open_emulated_port(f"--{name}", place, line, names / name)
                stack.callback(port.close)
                self.urls[name] = port.url
                is_base = line is base
                ports.append(options.base.pumped(port, self.rig.base) if is_base else port)
            if options.camera is not None:
                camera = open_camera(options.camera, world, self.rig.body)
                stack.callback(camera.close)
                self.urls["camera"] = camera.url
                ports.append(camera)
            self._closing = stack.pop_all()
        self._real_time = RealTimeRig(self.rig, ports)

    def close(self) -> None:
        """Close the ports."""
        self._closing.close()

    def run(self, going_on: Callable[[], bool]) -> None:
        """Serve clients in real time while ``going_on()`` is true."""
        while going_on():
            self._base.press(self.rig.base, time.monotonic() - self._started_at)
            self._real_time.step()


def open_emulated_port(option: str, place: str, line: LineFaults, name: Path) -> PtyPort | TcpPort:
    """Serve a device's line on ``pty`` or ``tcp:PORT``; cuts of its fault plan unplug the port.

    A pty whose plan has cuts gets the persistent ``name``. Raises EmulateError naming ``option``.
    """
    port = open_port(option, place, line, name if line.plan.cuts else None)
    line.on_cut = lambda _: port.unplug()
    line.on_restored = lambda _: port.plug_in()
    return port


def open_port(
    option: str, place: str, device: EmulatedDevice, name: Path | None
) -> PtyPort | TcpPort:
    """Serve a device on ``pty`` or ``tcp:PORT``; a pty gets the ``name``, if any.

    Raises EmulateError naming ``option``.
    """
    if place == "pty":
        return PtyPort(device, name)
    kind, _, number = place.partition(":")
    if kind != "tcp" or not number.isdecimal() or int(number) > 65535:
        raise EmulateError(f"{option} {place}: is neither pty nor tcp:PORT; use e.g. tcp:8101")
    try:
        return TcpPort(device, int(number))
    except OSError as error:
        raise EmulateError(
            f"{option} {place}: cannot listen there ({error.strerror}); choose another port, "
            "or tcp:0 for any free one"
        ) from error


def open_camera(port: int, world: World, body: RobotBody) -> CameraServer:
    """Serve a robot's camera pictures; raises EmulateError if the port is not available."""
    try:
        return CameraServer(EmulatedCamera(world, body).picture_at, port)
    except (OSError, OverflowError) as error:
        raise EmulateError(
            f"--camera {port}: cannot listen there ({error}); choose another port, or 0 for any"
        ) from error


def parse_pose(text: str) -> Pose:
    """Parse X,Y,DEG (m, m, deg) as a pose in the map frame; raises EmulateError."""
    try:
        x, y, degrees = (float(part) for part in text.split(","))
    except ValueError as error:
        raise EmulateError(f"--pose {text}: is not X,Y,DEG; use e.g. 4.0,3.7,90") from error
    if not all(map(math.isfinite, (x, y, degrees))):
        raise EmulateError(f"--pose {text}: is not a place; use e.g. 4.0,3.7,90")
    return Pose(x, y, math.remainder(math.radians(degrees), math.tau))


def _free_pose(folder: MapFolder, world: World, rng: np.random.Generator, reach: float) -> Pose:
    if folder.border is None:
        raise EmulateError(f"map {folder.name} has no border to stand near: give a place by --pose")
    return free_start_poses(world.occupancy, folder.border, 1, rng, reach)[0]

"""Process of a demo's world: simulated bodies, lasers and bases in real time, on pseudo-terminals;
cameras, if wanted, as MJPEG streams.

Prints one JSON line with each robot's ports and true start pose, then runs until SIGTERM, writing
the true poses as JSON lines.
"""

from __future__ import annotations

import argparse
import json
import signal
import sys
import time
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import IO

import numpy as np

from drivers.emulation.port import PtyPort, TcpPort
from maps.map_folder import load_map_folder
from tools.simulation.emulated_camera import CameraServer, EmulatedCamera
from tools.simulation.rig import RobotRig, make_rigs, outline_of
from tools.simulation.start_poses import free_start_poses
from tools.simulation.stranger import Stranger, make_strangers
from tools.simulation.true_world import make_world
from tools.simulation.truth.truth import load_truth
from tools.simulation.world import World

STEP_S = 0.01
TRUTH_PERIOD_S = 0.1
MAX_LAG_S = 0.05
"""A step later than this restarts the schedule instead of catching up."""


def laser_port(rig: RobotRig) -> PtyPort | TcpPort:
    """Serve a robot's laser where its kind has its plug: a serial line or a network."""
    return TcpPort(rig.laser) if rig.truth.laser.kind == "lms1xx" else PtyPort(rig.laser)


class WorldServer:
    """Steps the world in real time and pumps the ports."""

    def __init__(
        self,
        world: World,
        rigs: list[RobotRig],
        truth: IO[str],
        strangers: Sequence[Stranger] = (),
        *,
        cameras: bool = False,
    ) -> None:
        """Open base and laser port of each robot, and its camera stream if ``cameras``."""
        self._world = world
        self._rigs = rigs
        self._truth = truth
        self._strangers = strangers
        self.cameras = {
            rig.name: CameraServer(
                EmulatedCamera(world, rig.body, rig.truth.camera, rig.truth.band).picture_at
            )
            for rig in rigs
            if cameras
        }
        self._ended = False
        self.ports = {rig.name: (PtyPort(rig.base), laser_port(rig)) for rig in rigs}

    def describe(self) -> str:
        """Return one JSON line: every robot's name, port URLs and true start pose."""
        return json.dumps(
            [
                {
                    "name": rig.name,
                    "base": self.ports[rig.name][0].url,
                    "laser": self.ports[rig.name][1].url,
                    "camera": self.cameras[rig.name].url if self.cameras else "",
                    "start": list(rig.body.pose),
                }
                for rig in self._rigs
            ]
        )

    def end(self) -> None:
        """Make ``run`` return after the present step; may be called by a signal handler."""
        self._ended = True

    def run(self) -> None:
        """Step every ``STEP_S`` of real time until ``end`` is called."""
        next_step = time.monotonic()
        next_truth = next_step
        last = next_step
        while not self._ended:
            now = time.monotonic()
            if now - next_step > MAX_LAG_S:
                next_step = now
            for stranger in self._strangers:
                stranger.advance(now - last)
            last = now
            for camera in self.cameras.values():
                camera.pump(now)
            for rig in self._rigs:
                for port in self.ports[rig.name]:
                    port.pump(now)
                rig.advance(now)
            if now >= next_truth:
                self._write_truth(now)
                next_truth = max(next_truth + TRUTH_PERIOD_S, now)
            next_step += STEP_S
            time.sleep(max(0.0, next_step - time.monotonic()))

    def _write_truth(self, now: float) -> None:
        """Write one line: monotonic time, contacts so far, each robot's true pose."""
        row = {
            "t": now,
            "contacts": self._world.contacts,
            "poses": {rig.name: list(rig.body.pose) for rig in self._rigs},
        }
        self._truth.write(json.dumps(row) + "\n")
        self._truth.flush()


def main() -> None:
    """Run one world until SIGTERM."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("map", type=Path)
    parser.add_argument("--border", required=True)
    parser.add_argument("--robots", type=int, required=True)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--strangers", type=int, default=0)
    parser.add_argument("--cameras", action="store_true")
    parser.add_argument("--truth", required=True)
    parser.add_argument("--poses", type=Path, required=True)
    options = parser.parse_args()
    folder = load_map_folder(options.map, options.border)
    assert folder.border is not None
    rng = np.random.default_rng(options.seed)
    truth = load_truth(options.truth)
    world = make_world(folder, rng, truth)
    reach = outline_of(truth.robot).reach
    starts = free_start_poses(world.occupancy, folder.border, options.robots, rng, reach)
    rigs = make_rigs(world, starts, time.monotonic(), truth)
    with ExitStack() as stack:
        poses = stack.enter_context(options.poses.open("w"))
        leg = truth.people.leg
        strangers = make_strangers(world, folder.border, options.strangers, options.seed, leg)
        server = WorldServer(world, rigs, poses, strangers, cameras=options.cameras)
        for camera in server.cameras.values():
            stack.callback(camera.close)
        for ports in server.ports.values():
            for port in ports:
                stack.callback(port.close)
        signal.signal(signal.SIGTERM, lambda *_: server.end())
        print(server.describe(), flush=True)
        sys.stdout.close()  # the parent reads one line only
        server.run()


if __name__ == "__main__":
    main()

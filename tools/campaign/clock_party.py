"""Monitor and robot with certificates, in a process whose clock is set from outside.

Usage: python -m tools.campaign.clock_party KEYS ENDPOINT. For each line on standard input one JSON
line on standard output: ``look`` tells what is so, ``again`` first makes the robot's link anew.
"""

from __future__ import annotations

import os
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, closing
from pathlib import Path

import msgspec

from maps.pose import Pose
from robot_agent.config import TelemetrySettings
from robot_agent.messages.foxglove import PoseInFrame, pose3, timestamp_at
from robot_agent.messages.streams import encode
from robot_agent.process.telemetry import Telemetry
from tools.campaign.footprint import Footprint, footprint_of
from tools.monitor.monitor import Monitor, MonitorOptions
from tools.monitor.site import Site

TEAM, ROBOT = "lab", "anna"
_LISTENING_S = 1.5
"""Time in which a robot that is linked is heard, and one that is refused says why."""
_LOOK_S = 0.05
POSE = encode(
    PoseInFrame(timestamp=timestamp_at(1.0), frame_id="map", pose=pose3(Pose(1.0, 2.0, 0.0)))
)
"""What a robot publishes to be heard."""


class Seen(msgspec.Struct):
    """What is so after a change of the clock."""

    year: int
    heard: bool
    """Whether the monitor has got a new payload of the robot."""
    failed: str
    """Why the robot's telemetry says that it has no operator; empty: no reason."""
    told: list[str]
    """What the monitor tells of its certificates."""
    handles: int
    threads: int
    memory_mb: float

    @property
    def footprint(self) -> Footprint:
        """What the process holds."""
        return Footprint(self.handles, self.threads, self.memory_mb)


def answer(keys: Path, endpoint: str, orders: Iterator[str]) -> Iterator[Seen]:
    """Carry out orders, each a line; yield what is seen after each."""
    settings = TelemetrySettings(operator=endpoint, keys=str(keys / ROBOT))
    options = MonitorOptions(endpoint, None, Site(None), keys=keys / "operator")
    with closing(Monitor(options)) as monitor, ExitStack() as stack:
        robot = stack.enter_context(closing(Telemetry(settings, robot=ROBOT, team=TEAM)))
        for order in orders:
            if order.strip() == "again":
                stack.close()
                robot = stack.enter_context(closing(Telemetry(settings, robot=ROBOT, team=TEAM)))
            yield _look(monitor, robot)


def _look(monitor: Monitor, robot: Telemetry) -> Seen:
    begun = time.monotonic()
    heard = False
    pause = threading.Event()  # of sleep with a set clock libfaketime makes an error
    while not heard and time.monotonic() < begun + _LISTENING_S:
        robot.publish("pose", POSE)
        pause.wait(_LOOK_S)
        heard = any(
            each.last_heard is not None and each.last_heard > begun
            for each in monitor.operator.team.snapshot()
        )
    told = [each.text for each in monitor.conditions()]
    held = footprint_of(os.getpid())
    year = time.gmtime().tm_year
    return Seen(year, heard, robot.failed, told, held.handles, held.threads, held.memory_mb)


if __name__ == "__main__":
    for seen in answer(Path(sys.argv[1]), sys.argv[2], sys.stdin):
        print(msgspec.json.encode(seen).decode(), flush=True)

"""What the operator knows of the team: the newest payload of every stream of every robot."""

from __future__ import annotations

import re
import threading
from collections.abc import Callable
from dataclasses import replace

from robot_agent.messages.streams import Payload, PayloadError, decode
from tools.monitor.robot_state import RobotState

MAX_ROBOTS = 64
"""More names than this on one network are a fault, not a team."""
MAX_PAYLOAD_BYTES = 256 * 1024
"""Our largest payload, 200 particles, has a tenth of this: more is a fault and is not decoded."""
_NAME = re.compile(r"[A-Za-z0-9_-]{1,64}")
"""What a team or robot may be called, as the robots' configuration has it."""


class TeamState:
    """Collects telemetry by key; any thread may write, any thread may take a snapshot.

    Nothing that arrives over the network can make it raise: what cannot be read is counted.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._robots: dict[tuple[str, str], RobotState] = {}
        self._version = 0
        self.stray = 0
        """How many messages came under a key that is no robot's, or of one robot too many."""
        self.stray_at: float | None = None
        """When the last of them came, s on the operator's monotonic clock."""

    def receive(self, key: str, data: bytes, t: float, wall: float | None = None) -> None:
        """Take one payload that arrived under ``patrol/<team>/<robot>/<stream>``.

        t: s on the operator's monotonic clock; wall: s since 1970, by default t.
        """
        at = t if wall is None else wall
        parts = key.split("/")
        stream = parts.pop()
        payload = _decoded(stream, data)
        if payload is None:
            self._update(parts, t, lambda robot: _with_malformed(robot, t))
        else:
            self._update(parts, t, lambda robot: robot.with_payload(stream, payload, t, at), stream)

    def set_liveliness(self, key: str, *, online: bool, t: float = 0.0) -> None:
        """Take note that the robot of ``patrol/<team>/<robot>`` came or went."""
        self._update(key.split("/"), t, lambda robot: replace(robot, online=online))

    def _update(
        self,
        parts: list[str],
        t: float,
        change: Callable[[RobotState], RobotState],
        stream: str = "",
    ) -> None:
        """Change the state of the robot that a key's parts name."""
        with self._lock:
            self._version += 1
            name = robot_name(parts)
            if name is None or (name not in self._robots and len(self._robots) >= MAX_ROBOTS):
                self.stray += 1
                self.stray_at = t
                return
            robot = change(self._robots.get(name, RobotState(*name)))
            versions = {**robot.versions, stream: self._version}
            self._robots[name] = replace(robot, version=self._version, versions=versions)

    def snapshot(self) -> list[RobotState]:
        """Return the robots, ordered by team and name."""
        with self._lock:
            return [self._robots[key] for key in sorted(self._robots)]

    def clear(self) -> None:
        """Forget every robot; the count of changes goes on."""
        with self._lock:
            self._robots.clear()


def _decoded(stream: str, data: bytes) -> Payload | None:
    """Return a payload, or None for bytes that are none."""
    if len(data) > MAX_PAYLOAD_BYTES:
        return None
    try:
        return decode(stream, data)
    except PayloadError:
        return None


def robot_name(parts: list[str]) -> tuple[str, str] | None:
    """Return team and robot of a key's parts, or None if it is no robot's."""
    if len(parts) != 3 or parts[0] != "patrol" or not all(map(_NAME.fullmatch, parts[1:])):
        return None
    return parts[1], parts[2]


def _with_malformed(robot: RobotState, t: float) -> RobotState:
    return replace(robot, malformed=robot.malformed + 1, malformed_at=t)

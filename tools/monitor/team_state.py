"""The team's telemetry: the newest payload of every stream of every robot."""

from __future__ import annotations

import re
import threading
from collections.abc import Callable
from dataclasses import replace

from maps.input_limits import BAD_DATA, MAX_PAYLOAD_BYTES
from robot_agent.messages.streams import Payload, PayloadError, decode
from tools.monitor.robot_state import RobotState

MAX_ROBOTS = 64
"""Most robots kept; a further one takes the place of one that is silent, or is not shown."""
GIVE_WAY_S = 5.0
"""Silence from which a robot gives way: several of a bad link's pauses."""
_MAX_ONLINE = 16 * MAX_ROBOTS
"""Most robots whose presence is remembered, shown or not."""
_NAME = re.compile(r"[A-Za-z0-9_-]{1,64}")
"""Valid names of a team or robot, as in the robots' configuration."""


class TeamState:
    """Collects telemetry by key; thread-safe.

    Nothing received over the network makes it raise: malformed payloads and unknown keys are
    counted.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._robots: dict[tuple[str, str], RobotState] = {}
        self._version = 0
        self._online: dict[tuple[str, str], None] = {}  # the latest last; shown or not
        self.stray = 0
        """Number of messages under a key of no robot, or of a robot beyond ``MAX_ROBOTS``."""
        self.stray_at: float | None = None
        """Operator's monotonic time of the last of them; None: none yet."""
        self.hidden: dict[str, float] = {}
        """Robots that were not shown of late, or gave way, with the time; the newest few."""

    def receive(
        self, key: str, data: bytes, t: float, wall: float | None = None, source: str | None = None
    ) -> None:
        """Take one payload received under ``patrol/<team>/<robot>/<stream>``.

        t: operator's monotonic time; wall: s since 1970, by default t; source: of the session it
        came from, None if unknown.
        """
        at = t if wall is None else wall
        parts = key.split("/")
        stream = parts.pop()
        if source is not None:
            self._update(parts, t, lambda robot: robot.with_source(source, t))
        payload = _decoded(stream, data)
        if payload is None:
            self.refuse(parts, t)
            return
        try:
            self._update(parts, t, lambda robot: robot.with_payload(stream, payload, t, at), stream)
        except BAD_DATA:
            self.refuse(parts, t)

    def refuse(self, parts: list[str], t: float) -> None:
        """Count a payload that cannot be used, of the robot that a key's parts name."""
        self._update(parts, t, lambda robot: robot.with_malformed(t))

    def set_liveliness(self, key: str, *, online: bool, t: float = 0.0) -> None:
        """Set whether the robot of ``patrol/<team>/<robot>`` is online.

        That is said once; a robot for which there is no room yet is online when it is shown.
        """
        parts = key.split("/")
        name = robot_name(parts)
        with self._lock:
            if name is not None:
                self._online.pop(name, None)
                if online:
                    self._online[name] = None
                if len(self._online) > _MAX_ONLINE:
                    del self._online[next(iter(self._online))]
        self._update(parts, t, lambda robot: replace(robot, online=online))

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
            if name is None:
                self.stray += 1
                self.stray_at = t
                return
            if name not in self._robots and not self._make_room(t):
                self._hide(name, t)
                return
            new = RobotState(*name, first_seen=t, online=name in self._online)
            robot = change(self._robots.get(name, new))
            versions = {**robot.versions, stream: self._version}
            self._robots[name] = replace(robot, version=self._version, versions=versions)
            self.hidden.pop(robot.id, None)

    def _make_room(self, t: float) -> bool:
        """Return whether a further robot can be kept; of the silent ones one gives way.

        Those that are offline do first, then the longest silent.
        """
        if len(self._robots) < MAX_ROBOTS:
            return True
        name, robot = max(
            self._robots.items(), key=lambda item: (not item[1].online, item[1].silence(t))
        )
        if robot.silence(t) < GIVE_WAY_S:
            name, robot = max(self._robots.items(), key=lambda item: item[1].silence(t))
        if robot.silence(t) < GIVE_WAY_S:
            return False
        del self._robots[name]
        self._hide(name, t)
        return True

    def _hide(self, name: tuple[str, str], t: float) -> None:
        """Note that a robot is not shown."""
        robot = "/".join(name)
        self.hidden.pop(robot, None)
        self.hidden[robot] = t
        if len(self.hidden) > MAX_ROBOTS:
            del self.hidden[next(iter(self.hidden))]

    def hidden_since(self, t: float) -> list[str]:
        """Return the robots that have not been shown at some time since t, and are not now."""
        with self._lock:
            return [robot for robot, at in self.hidden.items() if at >= t]

    def snapshot(self) -> list[RobotState]:
        """Return the robots, ordered by team and name."""
        with self._lock:
            return [self._robots[key] for key in sorted(self._robots)]

    def clear(self) -> None:
        """Remove every robot; the version keeps increasing."""
        with self._lock:
            self._robots.clear()
            self._online.clear()
            self.hidden.clear()


def _decoded(stream: str, data: bytes) -> Payload | None:
    """Return the payload, or None if it is malformed or too large."""
    if len(data) > MAX_PAYLOAD_BYTES:
        return None
    try:
        return decode(stream, data)
    except PayloadError:
        return None


def robot_name(parts: list[str]) -> tuple[str, str] | None:
    """Return team and robot of a split key, or None if it is not a robot's."""
    if len(parts) != 3 or parts[0] != "patrol" or not all(map(_NAME.fullmatch, parts[1:])):
        return None
    return parts[1], parts[2]

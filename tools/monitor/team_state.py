"""What the operator knows of the team: the newest payload of every stream of every robot."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

from robot_agent.foxglove import PoseInFrame
from robot_agent.streams import DecisionPayload, Payload, PayloadError, StatusPayload, decode

MAX_ROBOTS = 64
"""More names than this on one network are a fault, not a team."""


@dataclass(frozen=True, slots=True)
class RobotState:
    """One robot as last heard of; times are s on the operator's monotonic clock."""

    team: str
    robot: str
    online: bool = False  # its liveliness token is there
    last_heard: float | None = None  # when its last payload came, of any stream
    payloads: Mapping[str, Payload] = field(default_factory=lambda: MappingProxyType({}))
    received: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    malformed: int = 0  # payloads that could not be read

    @property
    def status(self) -> StatusPayload | None:
        """The newest status."""
        payload = self.payloads.get("status")
        return payload if isinstance(payload, StatusPayload) else None

    @property
    def decision(self) -> DecisionPayload | None:
        """The newest decision."""
        payload = self.payloads.get("decision")
        return payload if isinstance(payload, DecisionPayload) else None

    @property
    def pose(self) -> PoseInFrame | None:
        """The newest pose in the map frame."""
        payload = self.payloads.get("pose")
        return payload if isinstance(payload, PoseInFrame) else None


class TeamState:
    """Collects telemetry by key; any thread may write, any thread may take a snapshot.

    Nothing that arrives over the network can make it raise: what cannot be read is counted.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._robots: dict[tuple[str, str], RobotState] = {}
        self._stray = 0

    @property
    def stray(self) -> int:
        """How many messages came under a key that is no robot's, or of one robot too many."""
        return self._stray

    def receive(self, key: str, data: bytes, t: float) -> None:
        """Take one payload that arrived under ``patrol/<team>/<robot>/<stream>`` at t."""
        parts = key.split("/")
        stream = parts.pop()
        try:
            payload = decode(stream, data)
        except PayloadError:
            self._update(parts, lambda robot: replace(robot, malformed=robot.malformed + 1))
        else:
            self._update(parts, lambda robot: _with_payload(robot, stream, payload, t))

    def set_liveliness(self, key: str, *, online: bool) -> None:
        """Take note that the robot of ``patrol/<team>/<robot>`` came or went."""
        self._update(key.split("/"), lambda robot: replace(robot, online=online))

    def _update(self, parts: list[str], change: Callable[[RobotState], RobotState]) -> None:
        """Change the state of the robot that a key's parts name."""
        with self._lock:
            if len(parts) != 3 or parts[0] != "patrol":
                self._stray += 1
                return
            name = (parts[1], parts[2])
            if name not in self._robots and len(self._robots) >= MAX_ROBOTS:
                self._stray += 1
                return
            self._robots[name] = change(self._robots.get(name, RobotState(*name)))

    def snapshot(self) -> list[RobotState]:
        """Return the robots, ordered by team and name."""
        with self._lock:
            return [self._robots[key] for key in sorted(self._robots)]


def _with_payload(robot: RobotState, stream: str, payload: Payload, t: float) -> RobotState:
    return replace(
        robot,
        last_heard=t,
        payloads={**robot.payloads, stream: payload},
        received={**robot.received, stream: t},
    )

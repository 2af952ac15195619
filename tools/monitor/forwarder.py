"""Forwards the telemetry a site's monitor receives to a head office: one way.

The site's and the office's monitors are Zenoh routers without a direct connection. For each robot
of the site a publish-only session connects to the office and publishes that robot's payloads.
"""

from __future__ import annotations

import threading
from pathlib import Path

import msgspec

from robot_agent.config import TelemetrySettings
from robot_agent.process.telemetry import Telemetry
from tools.monitor.team_state import GIVE_WAY_S, MAX_ROBOTS, robot_name


class ForwardError(ValueError):
    """The office cannot be reached so; the message says why, with the remedy."""


class Forwarder:
    """One publish-only session per robot; never blocks or fails because of the office."""

    def __init__(self, office: str, keys: Path | None = None) -> None:
        """office: Zenoh endpoint of the office, e.g. ``tls/office.example:7447``.

        keys: the site's folder of the office's ``patrol keys``, for a tls endpoint. Raises
        ForwardError for one without keys, or that is none.
        """
        written = {"operator": office, "keys": "" if keys is None else str(keys.resolve())}
        try:
            self._settings = msgspec.convert(written, TelemetrySettings)
        except msgspec.ValidationError as error:
            raise ForwardError(
                f"--forward {office}: give tcp/HOST:PORT, or tls/HOST:PORT with --forward-keys, "
                "this site's folder of the office's `patrol keys --site`"
            ) from error
        self._robots: dict[tuple[str, str], Telemetry] = {}  # the longest silent first
        self._heard: dict[tuple[str, str], float] = {}
        self._lock = threading.Lock()

    @property
    def trouble(self) -> str:
        """Why the office hears nothing of a robot, in one line; empty if nothing is known."""
        with self._lock:
            return next((robot.failed for robot in self._robots.values() if robot.failed), "")

    @property
    def dropped(self) -> int:
        """Payloads dropped in favour of newer ones because the connection was too slow."""
        with self._lock:
            return sum(robot.dropped for robot in self._robots.values())

    def on_payload(self, key: str, payload: bytes, wall: float) -> None:
        """Queue a payload received under a key; takes microseconds."""
        *parts, stream = key.split("/")
        with self._lock:
            robot = self._robot(parts, wall)
        if robot is not None:  # None: not a robot's key, or more than MAX_ROBOTS that all report
            robot.publish(stream, payload)

    def _robot(self, parts: list[str], wall: float) -> Telemetry | None:
        name = robot_name(parts)
        if name is None or (name not in self._robots and not self._make_room(wall)):
            return None
        robot = self._robots.pop(name, None)
        if robot is None:
            robot = Telemetry(self._settings, robot=name[1], team=name[0])
        self._robots[name], self._heard[name] = robot, wall
        return robot

    def _make_room(self, wall: float) -> bool:
        """Return whether a further robot can be forwarded; the longest silent one gives way."""
        if len(self._robots) < MAX_ROBOTS:
            return True
        name, robot = next(iter(self._robots.items()))
        if abs(wall - self._heard[name]) < GIVE_WAY_S:
            return False
        del self._robots[name], self._heard[name]
        # Closing waits for the network, and this thread must not.
        threading.Thread(target=robot.close, name="forwarder closes", daemon=True).start()
        return True

    def close(self) -> None:
        """Close all sessions; idempotent."""
        with self._lock:
            for robot in self._robots.values():
                robot.close()

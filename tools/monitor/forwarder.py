"""Forwards the telemetry a site's monitor receives to a head office: one way.

The site's and the office's monitors are Zenoh routers without a direct connection. For each robot
of the site a publish-only session connects to the office and publishes that robot's payloads.
"""

from __future__ import annotations

import threading

from robot_agent.config import TelemetrySettings
from robot_agent.process.telemetry import Telemetry
from tools.monitor.team_state import MAX_ROBOTS, robot_name


class Forwarder:
    """One publish-only session per robot; never blocks or fails because of the office."""

    def __init__(self, office: str) -> None:
        """office: Zenoh endpoint of the office, e.g. ``tcp/office.example:7447``."""
        self._settings = TelemetrySettings(operator=office)
        self._robots: dict[tuple[str, str], Telemetry] = {}
        self._lock = threading.Lock()

    @property
    def dropped(self) -> int:
        """Payloads dropped in favour of newer ones because the connection was too slow."""
        with self._lock:
            return sum(robot.dropped for robot in self._robots.values())

    def on_payload(self, key: str, payload: bytes, _wall: float) -> None:
        """Queue a payload received under a key; takes microseconds."""
        *parts, stream = key.split("/")
        with self._lock:
            robot = self._robot(parts)
        if robot is not None:  # None: not a robot's key, or more than MAX_ROBOTS
            robot.publish(stream, payload)

    def _robot(self, parts: list[str]) -> Telemetry | None:
        name = robot_name(parts)
        if name is None or (name not in self._robots and len(self._robots) >= MAX_ROBOTS):
            return None
        if name not in self._robots:
            self._robots[name] = Telemetry(self._settings, robot=name[1], team=name[0])
        return self._robots[name]

    def close(self) -> None:
        """Close all sessions; idempotent."""
        with self._lock:
            for robot in self._robots.values():
                robot.close()

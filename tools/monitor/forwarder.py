"""Passes on what a site's monitor hears to a head office: one way, as the robots report.

The site's and the office's monitors are Zenoh routers that never talk to each other directly. For
each robot that is heard a publish-only session dials the office and says what the robot said.
"""

from __future__ import annotations

import threading

from robot_agent.config import TelemetrySettings
from robot_agent.process.telemetry import Telemetry
from tools.monitor.team_state import MAX_ROBOTS, robot_name


class Forwarder:
    """Dials an office for each robot; whatever the office does, the site's monitor goes on."""

    def __init__(self, office: str) -> None:
        """Take the office's endpoint, e.g. ``tcp/office.example:7447``."""
        self._settings = TelemetrySettings(operator=office)
        self._robots: dict[tuple[str, str], Telemetry] = {}
        self._lock = threading.Lock()

    @property
    def dropped(self) -> int:
        """Payloads that made room for newer ones, as the way to the office was too slow."""
        with self._lock:
            return sum(robot.dropped for robot in self._robots.values())

    def on_payload(self, key: str, payload: bytes, _wall: float) -> None:
        """Pass on a payload that came under a key; takes microseconds."""
        *parts, stream = key.split("/")
        with self._lock:
            robot = self._robot(parts)
        if robot is not None:  # None: no robot's, or of one robot too many
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

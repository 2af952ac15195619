"""When a robot of a bench first stood for a reason, and what it said about it."""

from __future__ import annotations

import math

from maps.pose import Pose
from robot_agent.agent import Agent

STANDS_S = 5.0
"""s without motion, with a reason, that count as standing."""
_MOVED = 0.02  # m
_TURNED = math.radians(2.0)
_OK = "ok"


class StandLog:
    """Finds a robot's first stand with a reason: neither a report of its health nor a warning.

    A robot that waits for a teammate, or turns in place, reports ``ok`` and does not count; nor
    does a blocked way alone, as an obstacle is a reason of the way and not of the robot.
    """

    def __init__(self) -> None:
        self.stood_s: float | None = None
        """Start of the first stand, s; None if there was none."""
        self.said: str | None = None
        """What the agent reported at its end: its health, then its warnings."""
        self.warned_s: dict[str, float] = {}
        """When each part of the agent first warned, s."""
        self._since: float | None = None
        self._place: Pose | None = None

    def sample(self, t: float, pose: Pose, agent: Agent) -> None:
        """Take the true pose and the agent's reports at t, s."""
        for part in agent.warnings:
            self.warned_s.setdefault(part, t)
        if self.stood_s is not None:
            return
        health = agent.health_summary.health()
        if health in (_OK, "gate: obstacle") or self._has_moved(pose):
            self._since, self._place = None, None
            return
        if self._since is None:
            self._since, self._place = t, pose
        elif t - self._since >= STANDS_S:
            self.stood_s = self._since
            warnings = [f"{part}: {words}" for part, words in agent.warnings.items()]
            self.said = "; ".join([health, *warnings])

    def _has_moved(self, pose: Pose) -> bool:
        place = self._place
        if place is None:
            return False
        turned = math.remainder(pose.theta - place.theta, math.tau)
        return math.dist(pose[:2], place[:2]) > _MOVED or abs(turned) > _TURNED

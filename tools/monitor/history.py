"""Samples of a robot, one per second for an hour, for plots and trails."""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

from robot_agent.messages.streams import ACTIONS
from tools.monitor.robot_state import RobotState

PERIOD_S = 1.0
SAMPLES_KEPT = 3600
_FRESH_S = 1.0


class HistorySample(NamedTuple):
    """Wall time (s), position (m, map frame), distance from the border (m) and action."""

    wall: float
    x: float
    y: float
    distance: float
    action: int  # index into ACTIONS; -1: unknown


class RobotHistory:
    """The samples of one robot."""

    def __init__(self, period: float = PERIOD_S) -> None:
        """period: s between two samples."""
        self._period = period
        self.count = 0
        """Number of samples ever taken, more than are kept."""
        self._samples: deque[HistorySample] = deque(maxlen=SAMPLES_KEPT)

    def sample(self, robot: RobotState, now: float, wall: float) -> None:
        """Take a sample if the robot's decision is fresh and the last one is a period ago.

        now: operator's monotonic time, s; wall: s since 1970.
        """
        age = robot.age("decision", now)
        if robot.decision is None or age is None or age > _FRESH_S:
            return
        if self._samples and 0.0 <= wall - self._samples[-1].wall < self._period:
            return
        decision = robot.decision
        pose = decision.pose
        action = ACTIONS.index(decision.action) if decision.action in ACTIONS else -1
        self._samples.append(
            HistorySample(wall, pose.x, pose.y, decision.distance_from_border, action)
        )
        self.count += 1

    def since(self, count: int, limit: int = SAMPLES_KEPT) -> list[HistorySample]:
        """Return the samples after the first ``count``, the newest ``limit`` at most."""
        missing = min(self.count - count, len(self._samples), limit)
        return list(self._samples)[-missing:] if missing > 0 else []

"""History of odometry, for the robot's pose at the time of a measurement."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections import deque

from drivers.p2os.base_state import BaseState
from maps.pose import Pose, wrap_angle

KEPT_S = 3.0
CARRIED_S = 0.5
"""s past the newest report up to which its speeds are extrapolated: five reports."""


class OdometryHistory:
    """``odom_from_base`` at any time within the last seconds."""

    def __init__(self) -> None:
        self._states: deque[BaseState] = deque()

    @property
    def latest(self) -> BaseState | None:
        """The newest base report, or None before the first."""
        return self._states[-1] if self._states else None

    def add(self, state: BaseState) -> None:
        """Append a base report; reports measured no later than the newest one are ignored."""
        if self._states and state.t <= self._states[-1].t:
            return
        self._states.append(state)
        while state.t - self._states[0].t > KEPT_S:
            self._states.popleft()

    def at(self, t: float) -> Pose | None:
        """Return ``odom_from_base`` at t: interpolated, or extrapolated past the newest report.

        None before the first report, for times older than the history (KEPT_S), and more than
        CARRIED_S past the newest report.
        """
        if not self._states or t < self._states[0].t:
            return None
        newest = self._states[-1]
        if t - newest.t > CARRIED_S:
            return None
        if t >= newest.t:
            return _carried_forward(newest, t - newest.t)
        after = bisect_left(self._states, t, key=lambda state: state.t)
        return _between(self._states[max(after - 1, 0)], self._states[after], t)

    def twist_at(self, t: float) -> tuple[float, float]:
        """Return the speeds v, m/s, and w, rad/s, reported nearest to t; zero without reports."""
        if not self._states:
            return 0.0, 0.0
        nearest = self._states[-1]
        for state in reversed(self._states):  # t is usually near the newest report
            if abs(state.t - t) > abs(nearest.t - t):
                break
            nearest = state
        return nearest.v, nearest.w


def _carried_forward(state: BaseState, dt: float) -> Pose:
    """Return the pose after dt, s, at the reported speeds."""
    heading = state.theta + 0.5 * state.w * dt
    return Pose(
        state.x + state.v * dt * math.cos(heading),
        state.y + state.v * dt * math.sin(heading),
        wrap_angle(state.theta + state.w * dt),
    )


def _between(a: BaseState, b: BaseState, t: float) -> Pose:
    """Return the pose at t, interpolated linearly; theta is unwrapped in base reports."""
    share = (t - a.t) / (b.t - a.t) if b.t > a.t else 1.0
    return Pose(
        a.x + share * (b.x - a.x),
        a.y + share * (b.y - a.y),
        wrap_angle(a.theta + share * (b.theta - a.theta)),
    )

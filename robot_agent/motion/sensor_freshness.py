"""Which of the streams that motion depends on are believed at the moment."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from drivers.lms200.scan import Scan
from drivers.p2os.base_state import BaseState
from robot_agent.messages.events import TICK_S
from robot_agent.messages.log_level import LogLevel
from robot_agent.motion.deadline_watch import DeadlineWatch
from robot_agent.motion.freshness_limits import (
    BASE,
    FROZEN_BASE,
    FROZEN_LASER,
    LASER,
    MIN_RETURNS,
    POSE,
    SONAR,
    FreshnessWatch,
)
from robot_agent.motion.frozen_watch import FrozenWatch

PAUSE_S = 0.3
"""A process held up for longer finds bytes in its ports whose age it cannot tell."""
OLD_BYTES_S = 0.15
"""So long after a pause reports and scans may have come from these buffers, and are left out."""


class SensorFreshness:
    """Hears every report and scan, and tells which are old, frozen, blind or missed."""

    def __init__(self) -> None:
        """Nothing has come yet."""
        self.deadline = DeadlineWatch()
        self._watch = FreshnessWatch()
        self._frozen_base = FrozenWatch(FROZEN_BASE)
        self._frozen_laser = FrozenWatch(FROZEN_LASER)
        self._blind = False  # as far as the latest scan tells
        self._last_tick = math.inf
        self._old_until = -math.inf  # s: bytes that arrive before had waited for us

    def tick(self, t: float) -> None:
        """Notice a pause of the whole process: what comes first after it is of unknown age."""
        lag = t - self._last_tick - TICK_S
        self._last_tick = t
        self.deadline.update(t, lag)
        if lag > PAUSE_S:
            self._old_until = t + OLD_BYTES_S

    def is_old(self, t: float) -> bool:
        """Tell whether bytes that arrive at t, s, may have waited through a pause."""
        return t < self._old_until

    def report_time(self, latest: BaseState | None) -> float | None:
        """Return when the latest report was measured, s; None: none, or it is not believed."""
        return None if latest is None or self._frozen_base.frozen else latest.t

    def scan_time(self, latest: float | None) -> float | None:
        """Return ``latest``, s, of a scan; None while the laser is blind, or stuck."""
        return None if self._blind or self._frozen_laser.frozen else latest

    def on_base_report(self, t: float, state: BaseState) -> None:
        """Take a base report that arrived at t, s."""
        self._frozen_base.update((state.x, state.y, state.theta), moving=_is_moving(state))
        if not self._frozen_base.frozen:
            self._watch.well(BASE, t)
        if state.sonar:
            self._watch.well(SONAR, t)

    def accept_scan(self, t: float, scan: Scan, base: BaseState | None) -> bool:
        """Tell a scan from that of a laser that is blind, or shows the same for ever."""
        moving = base is not None and _is_moving(base)
        self._frozen_laser.update(scan.ranges.tobytes(), moving=moving)
        returns = np.count_nonzero(np.isfinite(scan.ranges)) / max(scan.ranges.size, 1)
        self._blind = bool(returns < MIN_RETURNS)
        if self._blind or self._frozen_laser.frozen:
            return False
        self._watch.well(LASER, t)
        return True

    def on_localized(self, t: float) -> None:
        """Take note that the robot knows where it is, at t, s."""
        self._watch.well(POSE, t)

    def changes(self, t: float) -> Iterator[tuple[str, str, LogLevel]]:
        """Yield part, words and level for each stream that begins to be missed, or is back."""
        for stream, well in self._watch.changes(t):
            words = "is back" if well else f"none for {stream.max_age:g} s: {stream.reaction}"
            level = LogLevel.INFO if well else stream.level
            yield f"trust.{stream.name}", f"{stream.what}: {words}", level


def _is_moving(state: BaseState) -> bool:
    """Tell whether a base says that it moves, faster than its counters' resolution."""
    return abs(state.v) > 0.05 or abs(state.w) > 0.1

"""Validity of the streams that motion depends on: stale, frozen, blind, or buffered in a pause."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from drivers.p2os.base_state import BaseState
from drivers.scan import Scan
from robot_agent.messages.events import TICK_S
from robot_agent.messages.log_level import LogLevel
from robot_agent.messages.notice import Notice
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
"""s; after a longer pause of the process its ports hold buffered bytes of unknown age."""
OLD_BYTES_S = 0.15
"""s after a pause for which reports and scans may come from these buffers, and are rejected."""


class SensorFreshness:
    """Checks every report and scan; reports streams that are stale, frozen, blind or buffered."""

    def __init__(self) -> None:
        """Start without data."""
        self.deadline = DeadlineWatch()
        self._watch = FreshnessWatch()
        self._frozen_base = FrozenWatch(FROZEN_BASE)
        self._frozen_laser = FrozenWatch(FROZEN_LASER)
        self._blind = False  # by the latest scan
        self._last_tick = math.inf
        self._old_until = -math.inf  # bytes that arrive earlier may have been buffered

    def tick(self, t: float) -> None:
        """Process a tick; a late one reveals a pause of the process, after which bytes are old."""
        lag = t - self._last_tick - TICK_S
        self._last_tick = t
        self.deadline.update(t, lag)
        if lag > PAUSE_S:
            self._old_until = t + OLD_BYTES_S

    def is_old(self, t: float) -> bool:
        """Return whether bytes that arrive at t may have been buffered during a pause."""
        return t < self._old_until

    def report_time(self, latest: BaseState | None) -> float | None:
        """Return when the latest report was measured; None without one or if the base is frozen."""
        return None if latest is None or self._frozen_base.frozen else latest.t

    def scan_time(self, latest: float | None) -> float | None:
        """Return ``latest``, the time of a scan; None while the laser is blind or frozen."""
        return None if self._blind or self._frozen_laser.frozen else latest

    def on_base_report(self, t: float, state: BaseState) -> None:
        """Process a base report that arrived at t."""
        self._frozen_base.update((state.x, state.y, state.theta), moving=_is_moving(state))
        if not self._frozen_base.frozen:
            self._watch.mark_valid(BASE, t)
        if state.sonar:
            self._watch.mark_valid(SONAR, t)

    def accept_scan(self, t: float, scan: Scan, base: BaseState | None) -> bool:
        """Process a scan at t; return whether it is valid, not of a blind or frozen laser.

        base: the latest report, by which the robot moves or not; None without one.
        """
        moving = base is not None and _is_moving(base)
        self._frozen_laser.update(scan.ranges.tobytes(), moving=moving)
        returns = np.count_nonzero(np.isfinite(scan.ranges)) / max(scan.ranges.size, 1)
        self._blind = bool(returns < MIN_RETURNS)
        if self._blind or self._frozen_laser.frozen:
            return False
        self._watch.mark_valid(LASER, t)
        return True

    def on_localized(self, t: float) -> None:
        """Record a localized pose at t."""
        self._watch.mark_valid(POSE, t)

    def changes(self, t: float) -> Iterator[Notice]:
        """Yield a notice for each stream that became stale or fresh again by t."""
        for stream, well in self._watch.changes(t):
            words = "is back" if well else f"none for {stream.max_age:g} s: {stream.reaction}"
            level = LogLevel.INFO if well else stream.level
            yield Notice(t, f"trust.{stream.name}", f"{stream.what}: {words}", level)


def _is_moving(state: BaseState) -> bool:
    """Return whether the reported speed is above the resolution of the encoder counts."""
    return abs(state.v) > 0.05 or abs(state.w) > 0.1

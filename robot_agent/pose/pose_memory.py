"""The last localized pose, stored over a restart and valid only if the odometer has continued.

A base whose session is still open after its agent was killed continues to count, also when it is
pushed. A pose stored with the odometer's reading is therefore valid after a restart, moved by the
counts since. A base that was switched off, or opened in a new session, may have started at zero:
the motion in between is unknown then. A robot carried with its wheels off the floor is not detected
here, but by the scans that must confirm the pose.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

import msgspec

from drivers.p2os.odometer import RADIANS_PER_COUNT, counter_step, is_near_zero
from localization.estimate import Estimate
from localization.health import Health
from maps.pose import Pose
from robot_agent.messages.effects import Remember

Counters = tuple[int, int, int]
"""The base's own x, y and heading counters, as on the wire."""

POSITION_WRAP = 0x8000
"""Counts after which a position counter wraps: 27 m. (A heading has 12 bits.)"""
SIGMA_XY, SIGMA_THETA = 0.1, 0.05
"""m and rad; standard deviations of a remembered pose."""
SIGMA_PER_COUNTED = 0.2
"""m/m and rad/rad; added to them per distance and angle counted since it was stored."""
NOTE_PERIOD = 1.0
"""s between two updates of the stored pose."""
MAX_COUNTED = 1.5
"""m the odometer may have counted since the pose was stored: without an agent a robot rolls until
its watchdog stops it."""


class MemorySettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Settings of the pose stored over restarts."""

    file: Annotated[
        str,
        msgspec.Meta(
            description="File that keeps the last sure pose over a restart; empty: none is kept"
        ),
    ] = ""


class RememberedPose(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A sure pose (map_from_base, m and rad) and what the odometer read there, in counts.

    In a recording's configuration, where the agent found it at its start; not for hand-written
    files.
    """

    x: float
    y: float
    theta: float
    odometer_x: int
    odometer_y: int
    odometer_heading: int

    def carried_to(self, now: Counters, metres_per_count: float) -> Start | None:
        """Return the start pose at an odometer reading ``now``; None if that does not continue.

        It continues if it moved by less than ``MAX_COUNTED`` and neither reading is near zero, as
        after a reset.
        """
        noted = (self.odometer_x, self.odometer_y, self.odometer_heading)
        if all(map(is_near_zero, noted)) or all(map(is_near_zero, now)):
            return None
        counted = Pose(
            _step(now[0], noted[0]) * metres_per_count,
            _step(now[1], noted[1]) * metres_per_count,
            counter_step(now[2], noted[2]) * RADIANS_PER_COUNT,
        )
        ahead = Pose(0.0, 0.0, noted[2] * RADIANS_PER_COUNT).inverse()
        counted = ahead.compose(counted)._replace(theta=counted.theta)
        travel = math.hypot(counted.x, counted.y)
        if travel >= MAX_COUNTED:
            return None
        return Start(
            Pose(self.x, self.y, self.theta).compose(counted),
            SIGMA_XY + SIGMA_PER_COUNTED * travel,
            SIGMA_THETA + SIGMA_PER_COUNTED * abs(counted.theta),
        )


class Start(NamedTuple):
    """A start pose, map_from_base, with standard deviations in m and rad."""

    pose: Pose
    sigma_xy: float
    sigma_theta: float


class PoseMemory:
    """Decides when to store the pose: every NOTE_PERIOD while localized; deletes it once lost."""

    def __init__(self, settings: MemorySettings) -> None:
        self._settings = settings
        self._last: float | None = None
        self._forgotten = False

    def update(
        self,
        t: float,
        estimate: Estimate | None,
        odometry: Pose,
        counters: Counters | None,
        *,
        at_once: bool = False,
    ) -> Remember | None:
        """Return the effect that stores or deletes the pose at t; None if none is due.

        odometry: odom_from_base at the counters. at_once: store now if localized.
        """
        if not self._settings.file or estimate is None or counters is None:
            return None
        if estimate.health is Health.LOST and not self._forgotten:
            self._last, self._forgotten = None, True
            return Remember(b"{}")
        due = at_once or self._last is None or t - self._last >= NOTE_PERIOD
        if estimate.health is not Health.LOCALIZED or not due:
            return None
        self._last, self._forgotten = t, False
        return Remember(msgspec.json.encode(_remembered(estimate.pose_at(odometry), counters)))


def _remembered(pose: Pose, counters: Counters) -> RememberedPose:
    x, y, heading = counters
    return RememberedPose(
        x=pose.x,
        y=pose.y,
        theta=pose.theta,
        odometer_x=x,
        odometer_y=y,
        odometer_heading=heading,
    )


def _step(new: int, old: int) -> int:
    """Return the difference, counts, between two readings of a position counter of 15 bits."""
    return (new - old + POSITION_WRAP // 2) % POSITION_WRAP - POSITION_WRAP // 2

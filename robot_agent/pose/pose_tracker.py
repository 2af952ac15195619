"""Where the robot is: odometry, localization, and the pose kept over restarts."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drivers.p2os.session import P2osSession
from localization.estimate import Estimate
from localization.health import Health
from localization.localizer import Localizer
from maps.pose import Pose, wrap_angle
from robot_agent.messages.log_level import LogLevel
from robot_agent.messages.notice import Notice
from robot_agent.messages.outbox import Outbox
from robot_agent.pose.odometry_history import OdometryHistory
from robot_agent.pose.pose_memory import PoseMemory, RememberedPose
from robot_agent.pose.start_pose import StartPose

_LEVELS = {
    Health.LOCALIZED: LogLevel.INFO,
    Health.UNSURE: LogLevel.WARNING,
    Health.LOST: LogLevel.ERROR,
}


class PoseTracker:
    """The pose in the map, now and lately, and whether motion may rest on it."""

    def __init__(
        self,
        localizer: Localizer,
        memory: PoseMemory,
        base: P2osSession,
        outbox: Outbox,
        *,
        start: StartPose | None = None,
        remembered: RememberedPose | None = None,
    ) -> None:
        """Start the localizer at ``start``, or anywhere if None.

        ``remembered`` replaces that start at the first base report whose odometer goes on from it.
        """
        self._base = base
        self._outbox = outbox
        self.odometry = OdometryHistory()
        self.localizer = localizer
        self.trusted = False
        self._memory = memory
        self._to_recall = remembered
        if start is None:
            localizer.start_anywhere()
        else:
            pose = Pose(start.x, start.y, start.theta)
            localizer.start_at(pose, start.sigma_xy, start.sigma_theta)

    @property
    def health(self) -> Health | None:
        """How well the pose is known; None before the first scan."""
        estimate = self.localizer.estimate
        return None if estimate is None else estimate.health

    def update(
        self,
        t: float,
        scanned: float,
        odometry: Pose,
        points: NDArray[np.float64],
        ignored: NDArray[np.bool_] | None,
    ) -> Estimate:
        """Return the pose estimate after one scan.

        t: now, s. scanned: when the scan was measured, s. odometry: odom_from_base then. points:
        (n, 2), m, base_link. ignored: (n,) which of them end on what the map does not have.
        """
        estimate = self.localizer.update(scanned, odometry, points, ignored)
        # FreshnessLimit once localized, until lost: unsure alone gives no trust and takes none.
        self.trusted = estimate.health is not Health.LOST and (
            self.trusted or estimate.health is Health.LOCALIZED
        )
        self._outbox.add(Notice(t, "localization", estimate.health, _LEVELS[estimate.health]))
        return estimate

    def localized_pose_at(self, t: float) -> Pose | None:
        """Return map_from_base at t, s, which may be past; None unless localized."""
        return self._pose_at(t) if self.health is Health.LOCALIZED else None

    def trusted_pose_at(self, t: float) -> Pose | None:
        """Return map_from_base at t, s: the last estimate carried forward by odometry.

        None while motion may not rest on the pose.
        """
        return self._pose_at(t) if self.trusted else None

    def _pose_at(self, t: float) -> Pose | None:
        estimate = self.localizer.estimate
        odometry = self.odometry.at(t)
        return None if estimate is None or odometry is None else estimate.pose_at(odometry)

    def recall(self, t: float) -> None:
        """At the first base report, start from the remembered pose if the odometer agrees."""
        remembered, counters = self._to_recall, self._base.odometer_found
        if remembered is None or counters is None:
            return
        self._to_recall = None
        scale = self._base.model.conversion.distance
        start = remembered.carried_to(counters, scale)
        if start is None:
            words = "not believed: the odometer does not go on from it"
            self._outbox.add(Notice(t, "memory", f"remembered pose {words}", LogLevel.WARNING))
            return
        self.localizer.start_at(*start)
        self._outbox.add(Notice(t, "memory", "starts from the remembered pose", LogLevel.INFO))

    def remember(self, t: float, *, at_once: bool = False) -> None:
        """Keep the pose for the next start, when it is time or at once."""
        state = self.odometry.latest
        if state is None:
            return
        kept = self._memory.update(
            t,
            self.localizer.estimate,
            Pose(state.x, state.y, wrap_angle(state.theta)),
            self._base.odometer_counters,
            at_once=at_once,
        )
        if kept is not None:
            self._outbox.add(kept)

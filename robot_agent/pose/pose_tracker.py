"""Pose of the robot in the map: odometry, localization, and the pose kept over restarts."""

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
from robot_agent.pose.travel_watch import TravelWatch

_LEVELS = {
    Health.LOCALIZED: LogLevel.INFO,
    Health.UNSURE: LogLevel.WARNING,
    Health.LOST: LogLevel.ERROR,
}


class PoseTracker:
    """Pose in the map, present and recent; ``trusted``: whether it may be used for motion."""

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
        """Start the localizer at ``start``, or with a global search if None.

        ``remembered`` replaces that start at the first base report if the odometer continues from
        it. Raises MapError for a global search on a map without free floor.
        """
        self._base = base
        self._outbox = outbox
        self.odometry = OdometryHistory()
        self.localizer = localizer
        self.travel = TravelWatch()
        """While it finds a fault, the robot is lost."""
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
        """Health of the localization; None before the first scan."""
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

        t: now. scanned: when the scan was measured. odometry: odom_from_base then. points: (n, 2),
        m, base_link. ignored: (n,) which of them end on objects not in the map; None: none.
        """
        if self.travel.fault is not None and self.localizer.estimate is not None:
            estimate = self.localizer.disown(self.localizer.estimate)  # and search no further
        else:
            estimate = self.localizer.update(scanned, odometry, points, ignored)
        # Trusted once localized, until lost: unsure keeps the state before.
        self.trusted = estimate.health is not Health.LOST and (
            self.trusted or estimate.health is Health.LOCALIZED
        )
        self._outbox.add(Notice(t, "localization", estimate.health, _LEVELS[estimate.health]))
        return estimate

    def localized_pose_at(self, t: float) -> Pose | None:
        """Return map_from_base at t, which may be past; None unless localized."""
        return self._pose_at(t) if self.health is Health.LOCALIZED else None

    def trusted_pose_at(self, t: float) -> Pose | None:
        """Return map_from_base at t: the last estimate carried forward by odometry.

        None while the pose is not trusted.
        """
        return self._pose_at(t) if self.trusted else None

    def _pose_at(self, t: float) -> Pose | None:
        estimate = self.localizer.estimate
        odometry = self.odometry.at(t)
        return None if estimate is None or odometry is None else estimate.pose_at(odometry)

    def recall(self, t: float) -> None:
        """At the first base report, start from the remembered pose if the odometer continues it."""
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
        """Emit the effect that stores the pose for the next start, if due or at_once."""
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

"""Where the robot is: odometry, localization, and the pose kept over restarts."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drivers.p2os.session import P2osSession
from localization.estimate import Estimate
from localization.health import Health
from localization.localizer import Localizer
from maps.occupancy_map import OccupancyMap
from maps.pose import Pose, wrap_angle
from robot_agent.config import AgentConfig
from robot_agent.messages.foxglove import LogLevel
from robot_agent.pose.odometry_history import OdometryHistory
from robot_agent.pose.pose_memory import PoseMemory
from robot_agent.report.outbox import Outbox

_LEVELS = {
    Health.LOCALIZED: LogLevel.INFO,
    Health.UNSURE: LogLevel.WARNING,
    Health.LOST: LogLevel.ERROR,
}


class Whereabouts:
    """The pose in the map, now and lately, and whether it is to be trusted."""

    def __init__(
        self,
        config: AgentConfig,
        occupancy: OccupancyMap,
        rng: np.random.Generator,
        base: P2osSession,
        outbox: Outbox,
    ) -> None:
        """Start at the configured pose, or anywhere; the base's odometer may tell better."""
        self._reach = config.memory.reach
        self._base = base
        self._outbox = outbox
        self.odometry = OdometryHistory()
        self.localizer = Localizer(config.localization, occupancy, rng)
        self.trusted = False
        self._memory = PoseMemory(config.memory)
        self._to_recall = config.remembered
        if config.start is None:
            self.localizer.start_anywhere()
        else:
            start = config.start
            self.localizer.start_at(
                Pose(start.x, start.y, start.theta), start.sigma_xy, start.sigma_theta
            )

    @property
    def health(self) -> Health | None:
        """How well the pose is known; None before the first scan."""
        estimate = self.localizer.estimate
        return None if estimate is None else estimate.health

    def locate(
        self,
        t: float,
        scanned: float,
        odometry: Pose,
        points: NDArray[np.float64],
        ignored: NDArray[np.bool_] | None,
    ) -> Estimate:
        """Take a scan's points (n, 2), m, base_link, measured at ``scanned``; t: now, s.

        ``ignored``: (n,) which of them end on what the map does not have.
        """
        estimate = self.localizer.update(scanned, odometry, points, ignored)
        # Trusted once localized, until lost: unsure alone gives no trust and takes none.
        self.trusted = estimate.health is not Health.LOST and (
            self.trusted or estimate.health is Health.LOCALIZED
        )
        self._outbox.say(t, "localization", estimate.health, _LEVELS[estimate.health])
        return estimate

    def localized_pose_at(self, t: float) -> Pose | None:
        """Return map_from_base at t, which may be past, while localized; None else."""
        return self._pose_at(t) if self.health is Health.LOCALIZED else None

    def trusted_pose_at(self, t: float) -> Pose | None:
        """Return map_from_base at t: the last estimate carried forward by odometry.

        None while the pose is not to be trusted.
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
        start = remembered.carried_to(counters, self._base.model.conversion.distance, self._reach)
        if start is None:
            words = "not believed: the odometer does not go on from it"
            self._outbox.say(t, "memory", f"remembered pose {words}", LogLevel.WARNING)
            return
        self.localizer.start_at(*start)
        self._outbox.say(t, "memory", "starts from the remembered pose", LogLevel.INFO)

    def remember(self, t: float, *, at_once: bool = False) -> None:
        """Note the pose for the next start, when it is time or at once."""
        state = self.odometry.latest
        if state is None:
            return
        note = self._memory.note(
            t,
            self.localizer.estimate,
            Pose(state.x, state.y, wrap_angle(state.theta)),
            self._base.odometer_counters,
            at_once=at_once,
        )
        if note is not None:
            self._outbox.add(note)

"""Whom the robot sees: teammates and others by laser, sonar and camera; intruders at the border."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drivers.lms200.scan import Scan
from localization.estimate import Estimate
from localization.health import Health
from maps.map_folder import MapFolder
from maps.pose import Pose
from robot_agent.config import AgentConfig
from robot_agent.messages.effects import TakePicture
from robot_agent.messages.events import BlobsSeen, PictureTaken
from robot_agent.messages.foxglove import LogLevel
from robot_agent.obstacles.surroundings import Surroundings
from robot_agent.perception.camera_watch import CameraWatch
from robot_agent.perception.intruder_evidence import cut_out, points_near
from robot_agent.perception.intruders import Intruder, Intruders
from robot_agent.perception.pose_sigma import PoseSigma
from robot_agent.perception.scan_points import hits
from robot_agent.perception.tracker import TeammateTracker
from robot_agent.pose.pose_tracker import Whereabouts
from robot_agent.report.outbox import Outbox
from robot_agent.report.telemetry_builder import Reports


class Sight:
    """Follows who is there, and reports strangers who stay near the border."""

    def __init__(
        self,
        config: AgentConfig,
        folder: MapFolder,
        whereabouts: Whereabouts,
        reports: Reports,
        outbox: Outbox,
    ) -> None:
        """Nobody is seen yet; a folder without a border knows no intruders."""
        self._lens = config.camera
        self._whereabouts = whereabouts
        self._reports = reports
        self._outbox = outbox
        self.tracker = TeammateTracker(config.perception, folder.map, config.camera)
        self.camera = CameraWatch(config.camera)
        self.intruders = Intruders(config.perception, folder.border) if folder.border else None
        self._pictured: Intruder | None = None

    def known_among(
        self, t: float, odometry: Pose, points: NDArray[np.float64]
    ) -> NDArray[np.bool_] | None:
        """Return (n,) which points, m, base_link, end on tracked bodies; None: pose unknown."""
        estimate = self._whereabouts.localizer.estimate
        if estimate is None or estimate.health is not Health.LOCALIZED:
            return None
        return self.tracker.covered(t, estimate.pose_at(odometry), points)

    def see(self, t: float, scan: Scan, estimate: Estimate, points: NDArray[np.float64]) -> None:
        """Take a scan's points (n, 2), m, base_link at the estimated pose; t: now, s."""
        if estimate.health is Health.LOST:
            return
        reflectors = None if scan.reflectors is None else scan.reflectors[hits(scan)]
        sigma = PoseSigma.of(estimate.covariance)
        self.tracker.update(scan.t, estimate.pose, points, reflectors, sigma)
        if estimate.health is Health.LOCALIZED:
            self._watch_intruders(t, scan.t, estimate.pose, points)

    def take_blobs(self, event: BlobsSeen) -> None:
        """Take in what a picture shows of the team's colour."""
        self.camera.hear(event)
        pose = self._whereabouts.localized_pose_at(event.taken)
        if pose is not None and event.sight == "clear":
            self.tracker.see_bands(event.taken, pose, event.blobs)

    def hear_behind(self, t: float, odometry: Pose, surroundings: Surroundings) -> None:
        """Let the sonars keep up teammates whom the laser does not see."""
        pose = self._whereabouts.localized_pose_at(t)
        if pose is not None and self.tracker.awaits_echo(t):
            self.tracker.hear(t, pose, surroundings.echoes(t, odometry))

    def _watch_intruders(
        self, t: float, scanned: float, pose: Pose, points: NDArray[np.float64]
    ) -> None:
        """Report strangers who stay near the border: once, then what has changed."""
        if self.intruders is None:
            return
        for new in self.intruders.update(scanned, self.tracker.tracks):
            words = (
                f"intruder {new.number} at ({new.x:.1f}, {new.y:.1f}), {new.distance:.1f} m from "
                f"the border at s = {new.abscissa:.1f} m"
            )
            self._outbox.say(t, "intruder", words, LogLevel.WARNING)
            near = points_near(points, pose, (new.x, new.y))
            self._outbox.publish(self._reports.on_intruder(t, new, scan=near))
            if self.camera.state(t) == "clear":
                self._pictured = new
                self._outbox.add(TakePicture())
        if self._outbox.publishes:
            self._outbox.publish(self._reports.on_intruders(t, self.intruders.known))

    def take_picture(self, event: PictureTaken) -> None:
        """Add a picture to the report of the intruder it was taken of."""
        intruder, self._pictured = self._pictured, None
        pose = self._whereabouts.localized_pose_at(event.taken)
        if intruder is None or pose is None:
            return
        picture = cut_out(event.jpeg, self._lens, pose, (intruder.x, intruder.y))
        if picture:
            self._outbox.publish(self._reports.on_intruder(event.t, intruder, picture=picture))

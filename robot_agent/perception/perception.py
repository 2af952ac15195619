"""Tracks of teammates and others, by laser, sonar and camera; intruders at the border."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drivers.camera_source import CameraSettings
from drivers.scan import Scan
from localization.estimate import Estimate
from localization.health import Health
from maps.map_folder import MapFolder
from maps.pose import Pose
from robot_agent.messages.events import BlobsSeen, PictureTaken
from robot_agent.perception.camera_watch import CameraWatch
from robot_agent.perception.intruder_evidence import cut_out, points_near
from robot_agent.perception.intruders import Intruder, Intruders
from robot_agent.perception.pose_sigma import PoseSigma
from robot_agent.perception.scan_points import hits
from robot_agent.perception.settings import PerceptionSettings
from robot_agent.perception.silhouette import Corners, Silhouettes
from robot_agent.perception.tracker import TeammateTracker


@dataclass(frozen=True, slots=True)
class NewIntruder:
    """An intruder to report for the first time."""

    intruder: Intruder
    scan: list[float]
    """Laser points near it: x, y, x, y, ... in the map frame, m."""
    needs_picture: bool
    """Whether to take a picture as evidence: the camera's state is "clear"."""


class Perception:
    """Tracks objects that are not in the map; strangers that stay near the border are intruders.

    ``intruders`` is None for a map without a border.
    """

    def __init__(
        self,
        settings: PerceptionSettings,
        camera: CameraSettings,
        folder: MapFolder,
        body: Corners,
        housing: tuple[float, float],
    ) -> None:
        """body: corners of the robot's own body, m; housing: depth and width of its scanner, m.

        Its teammates may have the same.
        """
        self._housing = housing
        self._lens = camera
        self._settings = settings
        silhouettes = Silhouettes.admitted(settings.silhouettes, body, housing)
        self.tracker = TeammateTracker(settings, folder.map, silhouettes, camera, folder.border)
        self.camera = CameraWatch(camera)
        self.intruders = Intruders(settings, folder.border) if folder.border else None
        self._pictured: Intruder | None = None

    def use_body(self, body: Corners, housing_ahead: float) -> None:
        """Admit the settings' silhouettes for another body of the robot, corners in m.

        housing_ahead: m from the body's middle to its scanner's housing, as teammates have it.
        """
        self.tracker.housing_ahead = housing_ahead
        self.tracker.silhouettes = Silhouettes.admitted(
            self._settings.silhouettes, body, self._housing
        )

    def tracked_points(
        self, t: float, estimate: Estimate | None, odometry: Pose, points: NDArray[np.float64]
    ) -> NDArray[np.bool_] | None:
        """Return (n,) which points (n, 2), m, base_link, end on tracked bodies.

        t: when they were measured. odometry: odom_from_base then. None unless localized, and if
        most points would be covered (``TeammateTracker.covered``).
        """
        if estimate is None or estimate.health is not Health.LOCALIZED:
            return None
        return self.tracker.covered(t, estimate.pose_at(odometry), points)

    def update(
        self, t: float, scan: Scan, estimate: Estimate, points: NDArray[np.float64]
    ) -> list[NewIntruder]:
        """Track with a scan's points (n, 2), m, base_link; return intruders not reported yet.

        t: now. estimate: pose at the scan. Does nothing and returns [] while lost.
        """
        if estimate.health is Health.LOST:
            return []
        reflectors = None if scan.reflectors is None else scan.reflectors[hits(scan)]
        sigma = PoseSigma.of(estimate.covariance)
        self.tracker.update(scan.t, estimate.pose, points, reflectors, sigma)
        if estimate.health is not Health.LOCALIZED or self.intruders is None:
            return []
        return [
            self._new_intruder(t, intruder, estimate.pose, points)
            for intruder in self.intruders.update(scan.t, self.tracker.tracks)
        ]

    def _new_intruder(
        self, t: float, intruder: Intruder, pose: Pose, points: NDArray[np.float64]
    ) -> NewIntruder:
        near = points_near(points, pose, (intruder.x, intruder.y))
        sees = self.camera.state(t) == "clear"
        if sees:
            self._pictured = intruder
        return NewIntruder(intruder, near, sees)

    def on_blobs(self, event: BlobsSeen, pose: Pose | None) -> None:
        """Update tracks with a picture's bands.

        pose: map_from_base when it was taken; None if unknown: then only the camera's state is
        updated.
        """
        self.camera.on_picture(event)
        if pose is not None and event.sight == "clear":
            self.tracker.on_bands(event.taken, pose, event.blobs)

    def on_picture(self, event: PictureTaken, pose: Pose | None) -> tuple[Intruder, str] | None:
        """Return the intruder a picture was requested for, with its cut-out (JPEG, base64).

        pose: map_from_base when it was taken; None if unknown. Returns None without a request,
        without a pose, or if the picture does not show the place.
        """
        intruder, self._pictured = self._pictured, None
        if intruder is None or pose is None:
            return None
        picture = cut_out(event.jpeg, self._lens, pose, (intruder.x, intruder.y))
        return (intruder, picture) if picture else None

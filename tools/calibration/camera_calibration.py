"""Fits the camera's direction and focal length to robots seen by laser and camera at once."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from drivers.camera_source import CameraSettings
from maps.map_folder import map_folder_from_files
from maps.pose import Pose
from robot_agent.agent import Agent
from robot_agent.messages.events import BlobsSeen, Event
from tools.calibration.color_calibration import CalibrationError
from tools.logs.recorded_config import recorded_config
from tools.logs.recording import Recording

MIN_PAIRS = 20
MIN_SPREAD = 0.15  # rad, one sigma of the bearings: the focal length shows at the sides only
_FARTHEST = 0.5  # rad, largest angle between a band and the only robot near it
_MIN_CONFIDENCE = 0.6  # least confidence of a band that is used
_FRESH = 0.3  # s
_OUTLIER = 4.0  # pixels


@dataclass(frozen=True, slots=True)
class Pair:
    """Bearing of a robot from the lens, rad, base_link, and its band's offset to the right of the
    picture's middle, pixels."""

    bearing: float
    across: float


@dataclass(frozen=True, slots=True)
class CameraFit:
    """Fitted heading of the camera in base_link, rad, left positive; focal length and residual rms,
    pixels; number of pairs."""

    theta: float
    focal_length: float
    rms: float
    pairs: int


def pairs_of(recording: Recording) -> tuple[list[Pair], CameraSettings]:
    """Return the pairs of a recording, and its camera settings.

    A pair is taken where the laser saw one robot near the only band of a picture. The recording is
    replayed to know the agent's tracks. Raises ConfigError, MapError or BorderError for a damaged
    header.
    """
    header = recording.header
    config, _ = recorded_config(recording)
    folder = map_folder_from_files(config.map.folder, header.map_files, config.map.border)
    agent = Agent(config, folder, header.start_wall_ns)
    pairs = []
    for item in recording.items():
        if not isinstance(item, Event):
            continue
        agent.handle(item)
        if isinstance(item, BlobsSeen):
            pairs += _pair(agent, item, config.camera)
    return pairs, config.camera


def _pair(agent: Agent, event: BlobsSeen, camera: CameraSettings) -> list[Pair]:
    pose = agent.pose_tracker.localized_pose_at(event.taken)
    if pose is None or len(event.blobs) != 1 or event.blobs[0].confidence < _MIN_CONFIDENCE:
        return []
    lens = pose.compose(Pose(camera.mount[0], camera.mount[1], 0.0))
    bearings = [
        math.remainder(math.atan2(track.y - lens.y, track.x - lens.x) - lens.theta, math.tau)
        for track in agent.perception.tracker.tracks
        if track.robot_sized and event.taken - track.last_seen < _FRESH
    ]
    seen_at = event.blobs[0].bearing + camera.mount[2]
    near = [bearing for bearing in bearings if abs(bearing - seen_at) < _FARTHEST]
    if len(near) != 1:
        return []
    return [Pair(near[0], -camera.focal_length * math.tan(event.blobs[0].bearing))]


def fit_camera(pairs: Sequence[Pair], camera: CameraSettings) -> CameraFit:
    """Fit direction and focal length by robust least squares, starting from the camera's settings.

    Raises CalibrationError for too few pairs, or pairs all in one direction.
    """
    if len(pairs) < MIN_PAIRS:
        raise CalibrationError(
            f"{len(pairs)} moments with one robot before laser and camera, {MIN_PAIRS} are "
            "needed: record a robot with its band that drives about before this one"
        )
    bearings = np.array([pair.bearing for pair in pairs])
    across = np.array([pair.across for pair in pairs])
    if bearings.std() < MIN_SPREAD:
        raise CalibrationError(
            f"the robot stayed within {math.degrees(bearings.std()):.1f} degrees (one sigma) of "
            "one direction: let it cross the whole picture"
        )
    found = least_squares(
        lambda p: -p[1] * np.tan(bearings - p[0]) - across,
        x0=(camera.mount[2], camera.focal_length),
        loss="soft_l1",
        f_scale=_OUTLIER,
        x_scale=(0.01, 10.0),
    )
    residuals = -found.x[1] * np.tan(bearings - found.x[0]) - across
    good = residuals[np.abs(residuals) < 3.0 * _OUTLIER]
    rms = float(np.sqrt(np.mean(good**2))) if good.size else math.inf
    return CameraFit(float(found.x[0]), float(found.x[1]), rms, len(pairs))

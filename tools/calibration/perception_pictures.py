"""Draws an intruder report of a recording: the scan with the tracks, the picture with the bands."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import cv2
import matplotlib as mpl
import numpy as np
from numpy.typing import NDArray

from drivers.camera_source import CameraSettings
from maps.map_folder import map_folder_from_files
from maps.occupancy_map import OCCUPIED, OccupancyMap
from maps.pose import Pose
from maps.whole_file import whole_file, write_whole
from robot_agent.agent import Agent
from robot_agent.messages.blob import Blob
from robot_agent.messages.events import BlobsSeen, Event, PictureTaken
from robot_agent.perception.identity import Kind
from robot_agent.perception.jpeg import decode_jpeg
from robot_agent.perception.scan_points import move_points
from robot_agent.perception.track import Track
from tools.logs.recorded_config import recorded_config
from tools.logs.recording import Recording, RecordingError

mpl.use("Agg")
from matplotlib import pyplot as plt
from matplotlib.axes import Axes

_COLORS = {Kind.TEAMMATE: "tab:blue", Kind.STRANGER: "tab:red", Kind.UNKNOWN: "0.5"}
_REACH = 4.5  # m drawn to either side of the robot
_ENLARGED = 2


@dataclass(frozen=True, eq=False)
class Moment:
    """State of the agent at the time of a picture."""

    occupancy: OccupancyMap
    agent: Agent
    pose: Pose
    points: NDArray[np.float64]
    """Obstacles seen near the robot, (n, 2), m, map frame."""
    blobs: tuple[Blob, ...]
    picture: NDArray[np.uint8]


def moment_of(recording: Recording) -> Moment:
    """Replay a recording up to the first picture of an intruder report with a known pose.

    Raises RecordingError if there is none.
    """
    header = recording.header
    config, _ = recorded_config(recording)
    folder = map_folder_from_files(config.map.folder, header.map_files, config.map.border)
    agent = Agent(config, folder, header.start_wall_ns)
    blobs: tuple[Blob, ...] = ()
    for item in recording.items():
        if not isinstance(item, Event):
            continue
        agent.handle(item)
        if isinstance(item, BlobsSeen):
            blobs = item.blobs
        if isinstance(item, PictureTaken):
            pose, odometry = (
                agent.pose_tracker.localized_pose_at(item.taken),
                agent.odometry.at(item.taken),
            )
            picture = decode_jpeg(item.jpeg)
            if pose is None or odometry is None or picture is None:
                continue
            points = move_points(agent.surroundings.seen_around(odometry), pose)
            return Moment(folder.map, agent, pose, points, blobs, picture)
    raise RecordingError(
        f"{recording.path}: no picture was taken, as no intruder came: record with strangers"
    )


def draw_scan(moment: Moment, path: Path) -> None:
    """Draw map, border, scan and tracks around the robot into a PNG."""
    figure, axes = plt.subplots(figsize=(6.0, 5.0), dpi=80)
    occupancy = moment.occupancy
    walls = occupancy.centres(np.argwhere(occupancy.cells == OCCUPIED))
    axes.plot(*walls.T, ",", color="0.6")
    if moment.agent.border is not None:
        axes.plot(
            *moment.agent.border.polyline(0.1).T, "--", color="tab:green", lw=1, label="border"
        )
    axes.plot(*moment.points.T, ".", color="black", ms=3, label="laser, within 2 m")
    px, py, theta = moment.pose
    axes.plot(px, py, "k^", ms=9)
    axes.plot([px, px + 0.5 * math.cos(theta)], [py, py + 0.5 * math.sin(theta)], "k-")
    for track in moment.agent.perception.tracker.tracks:
        _draw_track(axes, track)
    axes.set(xlim=(px - _REACH, px + _REACH), ylim=(py - 3.5, py + 3.5), xlabel="m", ylabel="m")
    axes.set_aspect("equal")
    axes.legend(loc="upper right", fontsize=8)
    figure.tight_layout()
    with whole_file(path) as part:
        figure.savefig(part)
    plt.close(figure)


def _draw_track(axes: Axes, track: Track) -> None:
    color = _COLORS[track.kind]
    values, vectors = np.linalg.eigh(track.covariance)
    angle = math.degrees(math.atan2(vectors[1, 1], vectors[0, 1]))
    width, height = 6.0 * np.sqrt(values[::-1])  # three sigma each way
    axes.add_patch(
        mpl.patches.Ellipse((track.x, track.y), width, height, angle=angle, fill=False, color=color)
    )
    axes.arrow(track.x, track.y, track.vx, track.vy, color=color, width=0.02)
    kinds = track.probabilities
    chance = max(kinds.teammate, kinds.stranger, kinds.unknown)
    axes.annotate(f"{track.kind} {chance:.2f}", (track.x, track.y + 0.35), color=color, fontsize=9)


def draw_picture(moment: Moment, path: Path) -> None:
    """Draw bands and tracks into the camera's picture, a JPEG."""
    camera = moment.agent.config.camera
    picture = cv2.resize(moment.picture, None, fx=_ENLARGED, fy=_ENLARGED)
    scale = _ENLARGED * camera.focal_length * moment.picture.shape[1] / camera.width
    middle = ((picture.shape[1] - 1) / 2, (picture.shape[0] - 1) / 2)
    for blob in moment.blobs:
        depth = scale / math.cos(blob.bearing)
        x = middle[0] - scale * math.tan(blob.bearing)
        y = middle[1] - depth * math.tan(blob.elevation)
        half = (0.5 * blob.width * scale, 0.5 * blob.height * scale)
        corners = [round(v) for v in (x - half[0], y - half[1], x + half[0], y + half[1])]
        cv2.rectangle(picture, (corners[0], corners[1]), (corners[2], corners[3]), (0, 255, 255), 1)
        words = f"band {blob.range:.1f} m {blob.confidence:.2f}"
        _write(picture, words, (corners[0], corners[1] - 6), (0, 255, 255))
    for track in moment.agent.perception.tracker.tracks:
        _mark_track(picture, track, moment.pose, camera, scale, middle)
    write_whole(path, cv2.imencode(path.suffix, picture)[1].tobytes())


def _mark_track(
    picture: NDArray[np.uint8] | cv2.typing.MatLike,
    track: Track,
    pose: Pose,
    camera: CameraSettings,
    scale: float,
    middle: tuple[float, float],
) -> None:
    at = pose.compose(Pose(*camera.mount)).between(Pose(track.x, track.y, 0.0))
    if at.x < 0.3:
        return
    foot = (
        round(middle[0] - scale * at.y / at.x),
        round(middle[1] + scale * camera.mount_height / at.x),
    )
    color = {Kind.TEAMMATE: (255, 120, 0), Kind.STRANGER: (0, 0, 255)}.get(track.kind, (90,) * 3)
    cv2.drawMarker(picture, foot, color, cv2.MARKER_TRIANGLE_UP, 12, 2)
    _write(picture, f"{track.kind} {at.x:.1f} m", (foot[0] - 40, foot[1] + 18), color)


def _write(
    picture: cv2.typing.MatLike, words: str, place: tuple[int, int], color: tuple[int, ...]
) -> None:
    cv2.putText(picture, words, place, cv2.FONT_HERSHEY_SIMPLEX, 0.45, color, 1, cv2.LINE_AA)

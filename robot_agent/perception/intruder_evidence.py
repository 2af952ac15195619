"""Evidence of an intruder: laser points near it and a cut-out of a picture."""

from __future__ import annotations

import base64
import math

import cv2
import numpy as np
from numpy.typing import NDArray

from drivers.camera_source import CameraSettings
from maps.pose import Pose
from robot_agent.perception.jpeg import decode_jpeg
from robot_agent.perception.scan_points import move_points

NEAR = 0.8
"""m round an intruder within which laser points are evidence, of it and of its surroundings."""
_HALF_WIDTH, _HEIGHT, _BELOW = 0.6, 2.0, 0.2  # m of the cut-out round a person
_QUALITY = 70


def points_near(points: NDArray[np.float64], pose: Pose, place: tuple[float, float]) -> list[float]:
    """Return x, y, x, y..., m, map frame, of the points (n, 2), base_link, near a place.

    pose: map_from_base when they were measured.
    """
    in_map = move_points(points, pose)
    near = np.hypot(in_map[:, 0] - place[0], in_map[:, 1] - place[1]) < NEAR
    flat: list[float] = np.round(in_map[near], 3).ravel().tolist()
    return flat


def cut_out(jpeg: bytes, camera: CameraSettings, pose: Pose, place: tuple[float, float]) -> str:
    """Return the part of a picture that shows a place, as JPEG in base64.

    Empty if the picture cannot be decoded or does not show the place. jpeg: the picture. pose:
    map_from_base when it was taken. place: (x, y), m, map frame.
    """
    at = pose.compose(Pose(*camera.mount)).between(Pose(*place, 0.0))
    picture = decode_jpeg(jpeg)
    if picture is None or at.x < 0.2:
        return ""
    rows, columns = picture.shape[:2]
    scale = camera.focal_length * columns / camera.width / at.x
    middle_x, middle_y = (columns - 1) / 2 - at.y * scale, (rows - 1) / 2
    left = max(math.floor(middle_x - _HALF_WIDTH * scale), 0)
    right = min(math.ceil(middle_x + _HALF_WIDTH * scale), columns)
    top = max(math.floor(middle_y - (_HEIGHT - camera.mount_height) * scale), 0)
    bottom = min(math.ceil(middle_y + (camera.mount_height + _BELOW) * scale), rows)
    if right - left < 2 or bottom - top < 2:
        return ""
    quality = [cv2.IMWRITE_JPEG_QUALITY, _QUALITY]
    _, cut = cv2.imencode(".jpg", picture[top:bottom, left:right], quality)
    return base64.b64encode(cut.tobytes()).decode()

"""Messages of the Foxglove schemas that are published, which a stock viewer draws without plug-in.

Field names, meanings and the requirement that every field be present are those of the published
``foxglove.*`` schemas. Lengths in m, angles in rad; JSON is written by msgspec, which has no inf
or nan, so builders never pass one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated

import msgspec
import numpy as np
from msgspec import Meta
from numpy.typing import NDArray

from maps.input_limits import MAX_BEAMS, MAX_PARTICLES, MAX_PARTS, MAX_SECONDS, MAX_TRACKS
from maps.pose import Pose
from robot_agent.messages.bounded_fields import Count, Number, Text, Word


class Timestamp(msgspec.Struct, frozen=True, kw_only=True):
    """A time, split as the Foxglove schemas want it."""

    sec: Annotated[int, Meta(ge=0, le=MAX_SECONDS, description="whole seconds")]
    nsec: Annotated[int, Meta(ge=0, le=999_999_999, description="nanoseconds")]


def timestamp_at(t: float, start_wall_ns: int = 0) -> Timestamp:
    """Return the time stamp of agent time t, in whole microseconds.

    With the run's ``start_wall_ns``, ns since 1970, it is a wall-clock time, without it the time
    since the start.
    """
    sec, nsec = divmod(start_wall_ns + round(t * 1e6) * 1000, 1_000_000_000)
    return Timestamp(sec=sec, nsec=nsec)


class Vector3(msgspec.Struct, frozen=True):
    """A position or a size (m)."""

    x: Number
    y: Number
    z: Number


class Quaternion(msgspec.Struct, frozen=True):
    """An orientation."""

    x: Number
    y: Number
    z: Number
    w: Number


class Pose3(msgspec.Struct, frozen=True):
    """A position and an orientation in space; ours lie in the plane z = 0."""

    position: Vector3
    orientation: Quaternion


def pose3(pose: Pose) -> Pose3:
    """Convert a planar pose to one in space."""
    half = 0.5 * pose.theta
    return Pose3(Vector3(pose.x, pose.y, 0.0), Quaternion(0.0, 0.0, math.sin(half), math.cos(half)))


def planar_pose(pose: Pose3) -> Pose:
    """Project a pose on the plane; the inverse of ``pose3``."""
    q = pose.orientation
    return Pose(pose.position.x, pose.position.y, 2.0 * math.atan2(q.z, q.w))


class PoseInFrame(msgspec.Struct, frozen=True, kw_only=True):
    """``foxglove.PoseInFrame``."""

    timestamp: Timestamp
    frame_id: Word
    pose: Pose3


class PosesInFrame(msgspec.Struct, frozen=True, kw_only=True):
    """``foxglove.PosesInFrame``."""

    timestamp: Timestamp
    frame_id: Word
    poses: Annotated[list[Pose3], Meta(max_length=MAX_PARTICLES)]


def poses_in_frame(timestamp: Timestamp, frame_id: str, poses: NDArray[np.float64]) -> PosesInFrame:
    """Wrap poses (n, 3) of x, y (m), theta (rad), rounded to 1 mm and 1 mrad."""
    rows: list[list[float]] = np.round(poses, 3).tolist()
    return PosesInFrame(
        timestamp=timestamp, frame_id=frame_id, poses=[pose3(Pose(*row)) for row in rows]
    )


class LaserScan(msgspec.Struct, frozen=True, kw_only=True):
    """``foxglove.LaserScan``. A beam without a usable return has range 0.0."""

    timestamp: Timestamp
    frame_id: Word
    pose: Pose3
    start_angle: Annotated[Number, Meta(description="bearing of the first beam (rad)")]
    end_angle: Annotated[Number, Meta(description="bearing of the last beam (rad)")]
    ranges: Annotated[
        list[Number],
        Meta(max_length=MAX_BEAMS, description="m; 0.0 where a beam had no usable return"),
    ]
    intensities: Annotated[list[Number], Meta(max_length=MAX_BEAMS)]


def laser_scan(
    timestamp: Timestamp,
    frame_id: str,
    angle_min: float,
    angle_increment: float,
    ranges: NDArray[np.float64],
) -> LaserScan:
    """Wrap a scan whose ranges (n,) are m, inf where there was no return; rounded to 1 mm.

    JSON has no inf, so "no return" is written as 0.0, which a laser never measures.
    """
    finite = np.where(np.isfinite(ranges), ranges, 0.0)
    return LaserScan(
        timestamp=timestamp,
        frame_id=frame_id,
        pose=pose3(Pose(0.0, 0.0, 0.0)),
        start_angle=angle_min,
        end_angle=angle_min + angle_increment * (len(ranges) - 1),
        ranges=np.round(finite, 3).tolist(),
        intensities=[],
    )


class CompressedImage(msgspec.Struct, frozen=True, kw_only=True):
    """``foxglove.CompressedImage``; in a recording its time counts from the agent's start."""

    timestamp: Timestamp
    frame_id: Word
    data: bytes
    format: Word


class Log(msgspec.Struct, frozen=True, kw_only=True):
    """``foxglove.Log``."""

    timestamp: Timestamp
    level: Annotated[int, Meta(ge=0, le=5, description="a LogLevel")]
    message: Text
    name: Annotated[Word, Meta(description="part of the agent that speaks")]
    file: Text = ""
    line: Count = 0


class KeyValuePair(msgspec.Struct, frozen=True):
    """A key and its value, both text."""

    key: Word
    value: Text


class Color(msgspec.Struct, frozen=True):
    """Red, green, blue and opacity, each 0 to 1."""

    r: Number
    g: Number
    b: Number
    a: Number


class CylinderPrimitive(msgspec.Struct, frozen=True, kw_only=True):
    """An upright cylinder; pose is its centre, size its extent along each axis (m)."""

    pose: Pose3
    size: Vector3
    bottom_scale: Number = 1.0
    top_scale: Number = 1.0
    color: Color


class ArrowPrimitive(msgspec.Struct, frozen=True, kw_only=True):
    """An arrow; pose is its tail, pointing along its x axis (lengths m)."""

    pose: Pose3
    shaft_length: Number
    shaft_diameter: Number
    head_length: Number
    head_diameter: Number
    color: Color


class UnusedPrimitive(msgspec.Struct, frozen=True):
    """Item of the primitive lists that a scene must name and that we leave empty."""


_Unused = Annotated[list[UnusedPrimitive], Meta(max_length=MAX_PARTS)]


class SceneEntity(msgspec.Struct, frozen=True, kw_only=True):
    """``foxglove.SceneEntity``: what is drawn under one id until its lifetime ends."""

    timestamp: Timestamp
    frame_id: Word
    id: Word
    lifetime: Timestamp
    frame_locked: bool = False
    metadata: Annotated[list[KeyValuePair], Meta(max_length=MAX_PARTS)]
    arrows: Annotated[list[ArrowPrimitive], Meta(max_length=MAX_PARTS)]
    cubes: _Unused = []
    spheres: _Unused = []
    cylinders: Annotated[list[CylinderPrimitive], Meta(max_length=MAX_PARTS)]
    lines: _Unused = []
    triangles: _Unused = []
    texts: _Unused = []
    models: _Unused = []


class SceneUpdate(msgspec.Struct, frozen=True, kw_only=True):
    """``foxglove.SceneUpdate``."""

    deletions: _Unused = []
    entities: Annotated[list[SceneEntity], Meta(max_length=MAX_TRACKS)]


TRACK_LIFETIME = Timestamp(sec=1, nsec=0)  # a track that is no longer published vanishes
TRACK_DIAMETER = 0.5  # m, about a robot
TRACK_HEIGHT = 0.3  # m
TEAMMATE_COLOR = Color(0.1, 0.4, 0.9, 0.8)
STRANGER_COLOR = Color(0.9, 0.3, 0.1, 0.8)
UNKNOWN_COLOR = Color(0.6, 0.6, 0.6, 0.8)


TRACK_COLORS = {
    "teammate": TEAMMATE_COLOR,
    "stranger": STRANGER_COLOR,
    "intruder": STRANGER_COLOR,
}


def track_entity(
    timestamp: Timestamp,
    track_id: int,
    position: Sequence[float],
    velocity: Sequence[float],
    *,
    kind: str,
    probability: float,
) -> SceneEntity:
    """Draw one track (map frame, m and m/s): a cylinder, and an arrow of its way in 1 s.

    kind: teammate, stranger, unknown, or intruder for a stranger that was reported as one;
    probability: of that kind.
    """
    color = TRACK_COLORS.get(kind, UNKNOWN_COLOR)
    x, y = position[0], position[1]
    vx, vy = velocity[0], velocity[1]
    arrow = ArrowPrimitive(
        pose=pose3(Pose(x, y, math.atan2(vy, vx))),
        shaft_length=math.hypot(vx, vy),
        shaft_diameter=0.05,
        head_length=0.1,
        head_diameter=0.1,
        color=color,
    )
    cylinder = CylinderPrimitive(
        pose=Pose3(Vector3(x, y, 0.5 * TRACK_HEIGHT), Quaternion(0.0, 0.0, 0.0, 1.0)),
        size=Vector3(TRACK_DIAMETER, TRACK_DIAMETER, TRACK_HEIGHT),
        color=color,
    )
    return SceneEntity(
        timestamp=timestamp,
        frame_id="map",
        id=f"track {track_id}",
        lifetime=TRACK_LIFETIME,
        metadata=[
            KeyValuePair("teammate", "true" if kind == "teammate" else "false"),
            KeyValuePair("kind", kind),
            KeyValuePair("probability", f"{probability:.3f}"),
        ],
        arrows=[arrow],
        cylinders=[cylinder],
    )

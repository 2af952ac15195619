"""ROS recordings (ROS 1 bags, ROS 2 bags in SQLite or MCAP) as laser logs, without ROS.

Read are one topic of ``LaserScan``, one of ``Odometry`` (else tf gives the odometry), and tf for
the laser's place on the robot and, where the recording has one, the robot's pose in a map. What is
read is a ``CarmenLog``, so all that takes logs takes bags.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from maps.input_limits import MAX_BEAMS
from maps.pose import Pose
from tools.logs.carmen import CarmenLog, CarmenScan, LogError
from tools.logs.ros_frames import FrameTree, Transform, transform_of

SCAN_TYPE = "sensor_msgs/msg/LaserScan"
ODOMETRY_TYPE = "nav_msgs/msg/Odometry"
TF_TYPES = ("tf2_msgs/msg/TFMessage", "tf/msg/tfMessage")
_MAP = "map"
_ODOM = "odom"
_BASES = ("base_footprint", "base_link")
_MCAP_HEAD = b"\x89MCAP0\r\n"


class RosTopics(NamedTuple):
    """Topics to read; None: the only one of its type."""

    scan: str | None = None
    odometry: str | None = None


@dataclass(slots=True, eq=False)
class _Content:
    """What was read of a bag, in its order."""

    scans: list[tuple[float, Any]] = field(default_factory=list)
    odometry: list[tuple[float, Pose]] = field(default_factory=list)
    base: str = ""
    frames: FrameTree = field(default_factory=FrameTree)


def is_ros_bag(path: Path) -> bool:
    """Whether a file or folder is a ROS recording, by its name and its first bytes."""
    if path.is_dir():
        return (path / "metadata.yaml").is_file()
    if path.suffix in (".bag", ".db3"):
        return True
    return path.suffix == ".mcap" and _mcap_profile(path) == "ros2"


def read_ros_bag(path: Path, topics: RosTopics = RosTopics()) -> CarmenLog:  # noqa: B008 - immutable
    """Read a ROS recording.

    Raises LogError naming file and remedy: not readable, no or several topics of a type, scans
    without odometry, or the package rosbags is missing.
    """
    content = _read(path, topics)
    if not content.scans:
        raise LogError(f"{path}: the topic of the scans has none: choose another by --scan-topic")
    notes: list[str] = []
    if not content.odometry:
        content.odometry, content.base = _odometry_of_tf(content.frames)
        notes.append(f"{path}: no odometry topic: taken from tf, {_ODOM} to {content.base or '?'}")
    if not content.odometry:
        raise LogError(f"{path}: no odometry, neither a topic nor tf from {_ODOM} to a base frame")
    frame = str(content.scans[0][1].header.frame_id).lstrip("/")
    mount = content.frames.fixed(content.base, frame)
    if mount is None:
        notes.append(f"{path}: tf has no way from {content.base} to {frame}: taken for one frame")
        mount = transform_of(_Origin())
    return _assemble(path, content, mount, notes)


def _assemble(path: Path, content: _Content, mount: Transform, notes: list[str]) -> CarmenLog:
    """Return the log: odometry of the laser, and reference poses where tf has a map."""
    stamps, poses = _in_order(content.odometry)
    inside = [(t, m) for t, m in content.scans if stamps[0] <= t <= stamps[-1]]
    late = len(content.scans) - len(inside)
    if late:
        notes.append(f"{path}: {late} scans outside the odometry's time left out")
    if not inside:
        raise LogError(f"{path}: no scan at a time of the odometry: are the clocks the same?")
    inside.sort(key=lambda each: each[0])
    times = [t for t, _ in inside]
    odometry = [at.compose(mount.planar) for at in _interpolated(stamps, poses, times)]
    corrections = content.frames.planar_at(_ODOM, times) if _has_map(content.frames) else None
    if mount.upside_down:
        notes.append(f"{path}: the laser is upside down, by tf: its scans are mirrored")
    start = times[0]
    scans = [
        CarmenScan(
            t=t - start,
            **_beams(path, message, mirrored=mount.upside_down),
            reference=at if corrections is None else corrections[number].compose(at),
            odometry=at,
        )
        for number, ((t, message), at) in enumerate(zip(inside, odometry, strict=True))
    ]
    knots = [
        (t - start, Pose(*pose).compose(mount.planar))
        for t, pose in zip(stamps.tolist(), poses.tolist(), strict=True)
    ]
    lines = sorted([*knots, *((scan.t, scan.odometry) for scan in scans)], key=lambda one: one[0])
    at_line = {t: number for number, (t, _) in enumerate(lines)}
    return CarmenLog(
        path=path,
        scans=scans,
        odometry=[one for number, one in enumerate(lines) if at_line[one[0]] == number],
        lines=lines,
        scan_lines=[at_line[scan.t] for scan in scans],
        referenced=corrections is not None,
        notes=notes,
    )


def _read(path: Path, topics: RosTopics) -> _Content:
    """Read the messages of the chosen topics and all of tf."""
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ImportError as error:
        raise LogError(f"{path}: needs rosbags: pip install 'border-patrol[ros]'") from error
    try:
        with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as bag:
            return _content_of(path, bag, topics)
    except LogError:
        raise
    except OSError as error:
        raise LogError(f"{path}: cannot be read ({error.strerror}): check the path") from error
    except Exception as error:
        # For a broken file rosbags, and what it stands on, raise errors of many kinds.
        raise LogError(f"{path}: not a readable ROS bag ({error!s:.120}): copy it again") from error


def _content_of(path: Path, bag: Any, topics: RosTopics) -> _Content:
    """Return the messages of an open bag."""
    known = bag.connections
    scan = _chosen(path, known, SCAN_TYPE, topics.scan, "--scan-topic")
    odometry = _chosen(path, known, ODOMETRY_TYPE, topics.odometry, "--odom-topic")
    if scan is None:
        raise LogError(f"{path}: no topic of {SCAN_TYPE}: it has {_listed(known)}")
    content = _Content()
    wanted = [each for each in known if each.topic in (scan, odometry) or each.msgtype in TF_TYPES]
    for connection, _, data in bag.messages(wanted):
        _take(content, connection, bag.deserialize(data, connection.msgtype), odometry)
    return content


def _take(content: _Content, connection: Any, message: Any, odometry: str | None) -> None:
    if connection.msgtype in TF_TYPES:
        for each in message.transforms:
            stamp = _seconds(each.header.stamp)
            transform = transform_of(each.transform)
            content.frames.add(stamp, each.header.frame_id, each.child_frame_id, transform)
    elif connection.msgtype == SCAN_TYPE:
        content.scans.append((_seconds(message.header.stamp), message))
    elif connection.topic == odometry:
        content.base = str(message.child_frame_id).lstrip("/") or content.base or _BASES[1]
        pose = transform_of(message.pose.pose).planar
        content.odometry.append((_seconds(message.header.stamp), pose))


def _chosen(
    path: Path, connections: Sequence[Any], kind: str, told: str | None, option: str
) -> str | None:
    """Return the topic told, or the only one of a type; None if there is none."""
    names = sorted({each.topic for each in connections if each.msgtype == kind})
    if told is not None:
        if told not in names:
            there = ", ".join(names) or "none at all"
            raise LogError(f"{path}: no topic {told} of {kind}, but {there}")
        return told
    if len(names) > 1:
        raise LogError(f"{path}: topics {', '.join(names)} are {kind}: choose one by {option}")
    return names[0] if names else None


def _listed(connections: Sequence[Any]) -> str:
    return ", ".join(sorted({f"{each.topic} ({each.msgtype})" for each in connections})[:20])


def _beams(path: Path, message: Any, *, mirrored: bool) -> dict[str, Any]:
    """Return ranges, angle_min and angle_increment of a scan, counter-clockwise from above."""
    ranges = np.asarray(message.ranges, dtype=np.float64)
    first, increment = float(message.angle_min), float(message.angle_increment)
    if not 2 <= len(ranges) <= MAX_BEAMS or not math.isfinite(first) or increment == 0.0:
        raise LogError(f"{path}: a scan of {len(ranges)} beams {increment:g} rad apart: no laser's")
    usable = (ranges >= message.range_min) & (ranges < message.range_max)
    ranges = np.where(usable, ranges, np.inf)
    if mirrored:
        first, increment = -first, -increment
    if increment < 0.0:
        first, increment, ranges = first + increment * (len(ranges) - 1), -increment, ranges[::-1]
    return {"ranges": ranges, "angle_min": first, "angle_increment": increment}


def _odometry_of_tf(frames: FrameTree) -> tuple[list[tuple[float, Pose]], str]:
    """Return the base's poses in ``odom`` by tf, and the base's frame; none without them."""
    for base in _BASES:
        if frames.parents.get(base) == _ODOM:
            return [(t, transform.planar) for t, transform in frames.history[base]], base
    return [], ""


def _has_map(frames: FrameTree) -> bool:
    return frames.parents.get(_ODOM) == _MAP


def _in_order(
    odometry: Sequence[tuple[float, Pose]],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return (n,) strictly increasing stamps, s, and (n, 3) poses with unwrapped headings."""
    stamps, first = np.unique([t for t, _ in odometry], return_index=True)
    poses = np.array([odometry[index][1] for index in first.tolist()])
    poses[:, 2] = np.unwrap(poses[:, 2])
    return stamps, poses


def _interpolated(
    stamps: NDArray[np.float64], poses: NDArray[np.float64], times: Sequence[float]
) -> Iterator[Pose]:
    for x, y, theta in zip(*(np.interp(times, stamps, axis) for axis in poses.T), strict=True):
        yield Pose(float(x), float(y), math.remainder(float(theta), math.tau))


def _seconds(stamp: Any) -> float:
    return int(stamp.sec) + 1e-9 * int(stamp.nanosec)


def _mcap_profile(path: Path) -> str:
    """Return the profile in an MCAP file's header record; empty if it has none."""
    try:
        with path.open("rb") as file:
            head = file.read(64)
    except OSError:
        return ""
    if not head.startswith(_MCAP_HEAD) or len(head) < 21 or head[8] != 1:
        return ""
    (length,) = struct.unpack_from("<I", head, 17)
    return head[21 : 21 + min(length, 32)].decode("utf-8", errors="replace")


class _Axes(NamedTuple):
    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    w: float = 1.0


class _Origin(NamedTuple):
    """The transform of one frame into itself, as a message has it."""

    translation: _Axes = _Axes()
    rotation: _Axes = _Axes()

"""Export of recordings as ROS 2 bags in MCAP, for rviz, nav2 and other ROS tools.

The frames are those of REP-105: ``map``, ``odom``, ``base_link``, ``laser``. Times are wall times.
"""

from __future__ import annotations

import math
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from drivers.scan import Scan
from maps.map_folder import map_folder_from_files
from maps.occupancy_map import FREE, OCCUPIED, OccupancyMap
from maps.pose import Pose
from robot_agent.messages.effects import Publish
from robot_agent.messages.events import Event
from robot_agent.messages.streams import DecisionPayload, decode
from robot_agent.recording.recording_writer import Reference
from tools.logs.carmen import LogError
from tools.logs.recorded_config import recorded_config
from tools.logs.recorded_scans import NEAREST_REFERENCE_S, ScanDecoder, recorded_mount
from tools.logs.recording import Recording
from tools.logs.ros_bag import ODOMETRY_TYPE, SCAN_TYPE, TF_TYPES

if TYPE_CHECKING:
    from rosbags.rosbag2 import Writer

_MAP_TYPE = "nav_msgs/msg/OccupancyGrid"
_TF_TYPE = TF_TYPES[0]
_BAG_VERSION: Literal[9] = 9  # of the metadata: ROS 2 Iron and later
_NEAREST_M, _FARTHEST_M = 0.02, 81.0  # of an LMS
_LETHAL, _UNKNOWN = 100, -1  # values of an OccupancyGrid


def recording_to_ros(recording: Recording, target: Path) -> int:
    """Write a recording as a ROS 2 bag, a new folder; return the number of scans.

    Topics: /scan, /odom, /tf, /tf_static and /map. ``map`` to ``odom`` is by the recording's
    reference if it has one, else by the agent's estimate. Raises LogError: the folder exists, the
    recording has no scan, or the package rosbags is missing.
    """
    if target.exists():
        raise LogError(f"{target}: exists: give the name of a new folder")
    try:
        from rosbags.rosbag2 import StoragePlugin, Writer
    except ImportError as error:
        raise LogError(f"{target}: needs rosbags: pip install 'border-patrol[ros]'") from error
    try:
        with Writer(target, version=_BAG_VERSION, storage_plugin=StoragePlugin.MCAP) as writer:
            return _write(writer, recording)
    except BaseException:
        shutil.rmtree(target, ignore_errors=True)  # half a bag is none
        raise


def _write(writer: Writer, recording: Recording) -> int:
    """Write all messages; return the number of scans; raises LogError if there is none."""
    messages = _Messages(recording.header.start_wall_ns)
    topics = {
        name: writer.add_connection(
            name, kind, typestore=messages.types, offered_qos_profiles=_qos(latched=latched)
        )
        for name, kind, latched in (
            ("/scan", SCAN_TYPE, False),
            ("/odom", ODOMETRY_TYPE, False),
            ("/tf", _TF_TYPE, False),
            ("/tf_static", _TF_TYPE, True),
            ("/map", _MAP_TYPE, True),
        )
    }
    scans = 0
    for name, t, message in _messages(recording, messages):
        data = messages.types.serialize_cdr(message, message.__msgtype__)
        writer.write(topics[name], messages.wall_ns(t), data)
        scans += name == "/scan"
    if not scans:
        raise LogError(f"{recording.path}: no scan with odometry in it: record some driving")
    return scans


def _messages(recording: Recording, ros: _Messages) -> Iterator[tuple[str, float, Any]]:
    """Yield topic, time and message in the recorded order."""
    config, _ = recorded_config(recording)
    decoder = ScanDecoder(config)
    files = recording.header.map_files
    if files:
        folder = map_folder_from_files(Path(config.map.folder).name, files, config.map.border)
        yield "/map", 0.0, ros.map(folder.map)
    yield "/tf_static", 0.0, ros.tf(0.0, "base_link", "laser", recorded_mount(recording, config))
    reference: Reference | None = None
    last: Pose | None = None
    for item in recording.items():
        if isinstance(item, Reference):
            reference = item
        elif isinstance(item, Publish) and item.stream == "decision" and reference is None:
            decision = decode(item.stream, item.payload)
            assert isinstance(decision, DecisionPayload)
            latest = decoder.latest
            if latest is not None:
                at = Pose(decision.pose.x, decision.pose.y, decision.pose.theta)
                correction = at.compose(latest[1].inverse())
                yield "/tf", latest[0], ros.tf(latest[0], "map", "odom", correction)
        elif isinstance(item, Event):
            found = decoder.scans(item)
            latest = decoder.latest
            if latest is not None and latest[1] != last:
                last = latest[1]
                yield "/odom", latest[0], ros.odometry(*latest)
                yield "/tf", latest[0], ros.tf(latest[0], "odom", "base_link", last)
            for scan, odometry in found:
                if reference is not None and abs(reference.t - scan.t) < NEAREST_REFERENCE_S:
                    correction = reference.pose.compose(odometry.inverse())
                    yield "/tf", scan.t, ros.tf(scan.t, "map", "odom", correction)
                yield "/scan", scan.t, ros.scan(scan)


class _Messages:
    """Makes ROS 2 messages of the product's data."""

    def __init__(self, start_wall_ns: int) -> None:
        from rosbags.typesys import Stores, get_typestore

        self.types: Any = get_typestore(Stores.ROS2_HUMBLE)
        self._start = start_wall_ns

    def wall_ns(self, t: float) -> int:
        """Return the wall time, ns since 1970, of a time of the recording, s."""
        return self._start + round(t * 1e9)

    def scan(self, scan: Scan) -> Any:
        """Return a LaserScan."""
        count = scan.ranges.size
        return self._make(
            SCAN_TYPE,
            header=self._header(scan.t, "laser"),
            angle_min=scan.angle_min,
            angle_max=scan.angle_min + scan.angle_increment * (count - 1),
            angle_increment=scan.angle_increment,
            time_increment=scan.turn_time * scan.angle_increment / math.tau,
            scan_time=scan.turn_time * scan.turns,
            range_min=_NEAREST_M,
            range_max=_FARTHEST_M,
            ranges=scan.ranges.astype(np.float32),
            intensities=np.empty(0, dtype=np.float32),
        )

    def odometry(self, t: float, pose: Pose) -> Any:
        """Return an Odometry without covariances and speeds."""
        none = np.zeros(36)
        twist = self._make(
            "geometry_msgs/msg/Twist", linear=self._vector(0, 0), angular=self._vector(0, 0)
        )
        at = self._make(
            "geometry_msgs/msg/PoseWithCovariance", pose=self._pose(pose), covariance=none
        )
        speed = self._make("geometry_msgs/msg/TwistWithCovariance", twist=twist, covariance=none)
        header = self._header(t, "odom")
        return self._make(
            ODOMETRY_TYPE, header=header, child_frame_id="base_link", pose=at, twist=speed
        )

    def tf(self, t: float, parent: str, child: str, pose: Pose) -> Any:
        """Return a TFMessage of one transform."""
        transform = self._make(
            "geometry_msgs/msg/Transform",
            translation=self._vector(pose.x, pose.y),
            rotation=self._turn(pose.theta),
        )
        stamped = self._make(
            "geometry_msgs/msg/TransformStamped",
            header=self._header(t, parent),
            child_frame_id=child,
            transform=transform,
        )
        return self._make(_TF_TYPE, transforms=[stamped])

    def map(self, occupancy: OccupancyMap) -> Any:
        """Return an OccupancyGrid."""
        rows, cols = occupancy.cells.shape
        value = np.full(occupancy.cells.shape, _UNKNOWN, dtype=np.int8)
        value[occupancy.cells == FREE] = 0
        value[occupancy.cells == OCCUPIED] = _LETHAL
        info = self._make(
            "nav_msgs/msg/MapMetaData",
            map_load_time=self._stamp(0.0),
            resolution=occupancy.resolution,
            width=cols,
            height=rows,
            origin=self._pose(occupancy.origin),
        )
        header = self._header(0.0, "map")
        return self._make(_MAP_TYPE, header=header, info=info, data=value.ravel())

    def _make(self, kind: str, **fields: Any) -> Any:
        return self.types.types[kind](**fields)

    def _stamp(self, t: float) -> Any:
        sec, nanosec = divmod(self.wall_ns(t), 10**9)
        return self._make("builtin_interfaces/msg/Time", sec=sec, nanosec=nanosec)

    def _header(self, t: float, frame: str) -> Any:
        return self._make("std_msgs/msg/Header", stamp=self._stamp(t), frame_id=frame)

    def _vector(self, x: float, y: float) -> Any:
        return self._make("geometry_msgs/msg/Vector3", x=float(x), y=float(y), z=0.0)

    def _turn(self, theta: float) -> Any:
        half = 0.5 * theta
        return self._make(
            "geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=math.sin(half), w=math.cos(half)
        )

    def _pose(self, pose: Pose) -> Any:
        place = self._make("geometry_msgs/msg/Point", x=pose.x, y=pose.y, z=0.0)
        return self._make(
            "geometry_msgs/msg/Pose", position=place, orientation=self._turn(pose.theta)
        )


def _qos(*, latched: bool) -> tuple[Any, ...]:
    """Return the quality of service of a topic: kept for late listeners, or ROS's default."""
    if not latched:
        return ()
    from rosbags.interfaces import (
        Qos,
        QosDurability,
        QosHistory,
        QosLiveliness,
        QosReliability,
        QosTime,
    )

    endless = QosTime(2147483647, 4294967295)
    return (
        Qos(
            QosHistory.KEEP_LAST,
            1,
            QosReliability.RELIABLE,
            QosDurability.TRANSIENT_LOCAL,
            endless,
            endless,
            QosLiveliness.AUTOMATIC,
            endless,
            avoid_ros_namespace_conventions=False,
        ),
    )

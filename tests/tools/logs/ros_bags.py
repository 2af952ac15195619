"""Bags for tests, written by rosbags: a robot that drives a loop in a room."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, Literal

import numpy as np

from maps.pose import Pose

TF = "tf2_msgs/msg/TFMessage"
ROOM = (-3.0, 4.0, -2.0, 3.0)  # m, its walls at x and y
MOUNT = Pose(0.1, 0.02, 0.05)
DRIFT = Pose(0.4, -0.2, 0.1)  # map_from_odom


def drive(count: int = 120) -> list[tuple[float, Pose]]:
    """Times, s, and poses on a circle of 1 m."""
    return [
        (0.2 * k, Pose(math.sin(0.05 * k), 1.0 - math.cos(0.05 * k), 0.05 * k))
        for k in range(count)
    ]


def ranges_at(laser: Pose, angles: np.ndarray) -> np.ndarray:
    """Ranges, m, of beams in the room from the laser's pose."""
    x0, x1, y0, y1 = ROOM
    c, s = np.cos(angles + laser.theta), np.sin(angles + laser.theta)
    with np.errstate(divide="ignore"):
        across = np.where(c > 0, (x1 - laser.x) / c, (x0 - laser.x) / c)
        up = np.where(s > 0, (y1 - laser.y) / s, (y0 - laser.y) / s)
    return np.minimum(across, up)


class Ros:
    """Makes messages and writes them as a ROS 1 or a ROS 2 bag."""

    def __init__(self, version: Literal[1, 2]) -> None:
        from rosbags.typesys import Stores, get_types_from_msg, get_typestore

        self.version = version
        store = Stores.ROS1_NOETIC if version == 1 else Stores.ROS2_HUMBLE
        self.types: Any = get_typestore(store)
        if version == 1:  # its bags define the types that they use
            definition = "geometry_msgs/TransformStamped[] transforms"
            self.types.register(get_types_from_msg(definition, TF))

    def make(self, kind: str, **fields: Any) -> Any:
        return self.types.types[kind](**fields)

    def header(self, t: float, frame: str) -> Any:
        sec, nanosec = divmod(round((1.7e9 + t) * 1e9), 10**9)
        stamp = self.make("builtin_interfaces/msg/Time", sec=sec, nanosec=nanosec)
        extra = {"seq": 0} if self.version == 1 else {}
        return self.make("std_msgs/msg/Header", stamp=stamp, frame_id=frame, **extra)

    def turn(self, roll: float, yaw: float) -> Any:
        c, s = math.cos(yaw / 2), math.sin(yaw / 2)
        cr, sr = math.cos(roll / 2), math.sin(roll / 2)
        quaternion = {"x": c * sr, "y": s * sr, "z": s * cr, "w": c * cr}
        return self.make("geometry_msgs/msg/Quaternion", **quaternion)

    def scan(self, t: float, ranges: np.ndarray, first: float, increment: float) -> Any:
        return self.make(
            "sensor_msgs/msg/LaserScan",
            header=self.header(t, "laser"),
            angle_min=first,
            angle_max=first + increment * (len(ranges) - 1),
            angle_increment=increment,
            time_increment=0.0,
            scan_time=0.1,
            range_min=0.1,
            range_max=20.0,
            ranges=ranges.astype(np.float32),
            intensities=np.empty(0, dtype=np.float32),
        )

    def odometry(self, t: float, pose: Pose) -> Any:
        zero = self.make("geometry_msgs/msg/Vector3", x=0.0, y=0.0, z=0.0)
        twist = self.make("geometry_msgs/msg/Twist", linear=zero, angular=zero)
        point = self.make("geometry_msgs/msg/Point", x=pose.x, y=pose.y, z=0.0)
        place = self.make(
            "geometry_msgs/msg/Pose", position=point, orientation=self.turn(0.0, pose.theta)
        )
        none = np.zeros(36)
        return self.make(
            "nav_msgs/msg/Odometry",
            header=self.header(t, "odom"),
            child_frame_id="base_link",
            pose=self.make("geometry_msgs/msg/PoseWithCovariance", pose=place, covariance=none),
            twist=self.make("geometry_msgs/msg/TwistWithCovariance", twist=twist, covariance=none),
        )

    def tf(self, t: float, parent: str, child: str, pose: Pose, roll: float = 0.0) -> Any:
        place = self.make("geometry_msgs/msg/Vector3", x=pose.x, y=pose.y, z=0.2)
        turn = self.turn(roll, pose.theta)
        transform = self.make("geometry_msgs/msg/Transform", translation=place, rotation=turn)
        stamped = self.make(
            "geometry_msgs/msg/TransformStamped",
            header=self.header(t, parent),
            child_frame_id=child,
            transform=transform,
        )
        return self.make(TF, transforms=[stamped])

    def write(self, path: Path, messages: list[tuple[str, float, Any]], plugin: str = "") -> Path:
        """Write messages by topic and time; plugin: "MCAP" or "SQLITE3" of a ROS 2 bag."""
        if self.version == 1:
            from rosbags.rosbag1 import Writer

            writer: Any = Writer(path)
        else:
            from rosbags.rosbag2 import StoragePlugin
            from rosbags.rosbag2 import Writer as Writer2

            writer = Writer2(path, version=9, storage_plugin=StoragePlugin[plugin])
        with writer:
            connections: dict[str, Any] = {}
            for topic, t, message in sorted(messages, key=lambda each: each[1]):
                kind = message.__msgtype__
                if topic not in connections:
                    connections[topic] = writer.add_connection(topic, kind, typestore=self.types)
                types = self.types
                encode = types.serialize_ros1 if self.version == 1 else types.serialize_cdr
                stamp = round((1.7e9 + t) * 1e9)
                writer.write(connections[topic], stamp, encode(message, kind))
        return path


def messages_of(
    ros: Ros,
    *,
    first: float = -2.356,
    increment: float = math.radians(0.5),
    beams: int = 541,
    odometry: bool = True,
    map_frame: bool = False,
    upside_down: bool = False,
) -> list[tuple[str, float, Any]]:
    """Return the messages of the drive: /scan, /odom or its tf, /tf_static, and map to odom."""
    roll = math.pi if upside_down else 0.0
    found = [("/tf_static", 0.0, ros.tf(0.0, "base_link", "laser", MOUNT, roll))]
    angles = first + increment * np.arange(beams)
    seen = -angles if upside_down else angles
    for t, pose in drive():
        if odometry:
            found.append(("/odom", t, ros.odometry(t, pose)))
        found.append(("/tf", t, ros.tf(t, "odom", "base_link", pose)))
        if map_frame:
            found.append(("/tf", t, ros.tf(t, "map", "odom", DRIFT)))
        ranges = ranges_at(pose.compose(MOUNT), seen)
        found.append(("/scan", t, ros.scan(t, ranges, first, increment)))
    return found

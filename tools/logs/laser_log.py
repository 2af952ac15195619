"""Laser logs of any kind that has odometry beside its scans: CARMEN logs and ROS bags."""

from __future__ import annotations

from pathlib import Path

from tools.logs.carmen import CarmenLog, read_carmen
from tools.logs.ros_bag import RosTopics, is_ros_bag, read_ros_bag


def read_laser_log(
    path: Path, max_range: float | None = None, topics: RosTopics | None = None
) -> CarmenLog:
    """Read a CARMEN log, plain or compressed, or a ROS bag.

    max_range: of a CARMEN log, as of ``read_carmen``. topics: of a bag, None: the only ones.
    Raises LogError naming file and remedy.
    """
    if is_ros_bag(path):
        return read_ros_bag(path, topics or RosTopics())
    return read_carmen(path, max_range)

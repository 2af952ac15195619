"""ROS bags of every kind, written by rosbags, read as laser logs; recordings as ROS 2 bags."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from maps.pose import Pose
from tests.tools.logs.ros_bags import DRIFT, MOUNT, ROOM, Ros, drive, messages_of
from tools.logs.carmen import LogError
from tools.logs.laser_log import read_laser_log
from tools.logs.ros_bag import RosTopics, is_ros_bag, read_ros_bag

pytest.importorskip("rosbags")


def walls_seen(path: Path, scans: int = 5) -> float:
    """Return the largest distance, m, of any scan's points from the room's walls."""
    log = read_laser_log(path)
    x0, x1, y0, y1 = ROOM
    worst = 0.0
    for scan in log.scans[:: len(log.scans) // scans]:
        x, y = scan.points().T
        c, s = math.cos(scan.odometry.theta), math.sin(scan.odometry.theta)
        mx, my = scan.odometry.x + c * x - s * y, scan.odometry.y + s * x + c * y
        off = np.minimum.reduce([abs(mx - x0), abs(mx - x1), abs(my - y0), abs(my - y1)])
        worst = max(worst, float(off.max()))
    return worst


@pytest.mark.parametrize(("version", "plugin"), [(1, ""), (2, "SQLITE3"), (2, "MCAP")])
def test_scans_of_bags_of_every_kind_lie_on_the_walls(
    tmp_path: Path, version: int, plugin: str
) -> None:
    ros = Ros(1 if version == 1 else 2)
    path = ros.write(
        tmp_path / ("drive.bag" if version == 1 else "drive"), messages_of(ros), plugin
    )
    assert is_ros_bag(path)
    log = read_laser_log(path)
    assert len(log.scans) == len(drive())
    assert log.notes == []
    assert (log.scans[0].t, log.scans[1].t) == (0.0, pytest.approx(0.2))
    assert log.scans[7].odometry == pytest.approx(drive()[7][1].compose(MOUNT), abs=1e-6)
    assert log.scans[7].reference == log.scans[7].odometry
    assert log.scan_lines == sorted(log.scan_lines)
    assert walls_seen(path) < 1e-3


def test_single_file_of_a_ros_2_bag_is_enough(tmp_path: Path) -> None:
    ros = Ros(2)
    for plugin, suffix in (("MCAP", ".mcap"), ("SQLITE3", ".db3")):
        (file,) = ros.write(tmp_path / plugin, messages_of(ros), plugin).glob(f"*{suffix}")
        assert is_ros_bag(file)
        assert len(read_ros_bag(file).scans) == len(drive())


def test_laser_upside_down_and_clockwise_scans_come_out_counter_clockwise(tmp_path: Path) -> None:
    ros = Ros(1)
    down = ros.write(tmp_path / "down.bag", messages_of(ros, upside_down=True))
    assert walls_seen(down) < 1e-3
    assert "upside down" in read_ros_bag(down).notes[0]
    back = messages_of(ros, first=2.356, increment=-math.radians(0.5))
    assert walls_seen(ros.write(tmp_path / "back.bag", back)) < 1e-3


def test_odometry_comes_from_tf_where_there_is_no_topic(tmp_path: Path) -> None:
    ros = Ros(1)
    path = ros.write(tmp_path / "tf.bag", messages_of(ros, odometry=False))
    assert walls_seen(path) < 1e-3
    assert "taken from tf" in read_ros_bag(path).notes[0]


def test_map_frame_gives_reference_poses(tmp_path: Path) -> None:
    ros = Ros(1)
    log = read_ros_bag(ros.write(tmp_path / "map.bag", messages_of(ros, map_frame=True)))
    at = DRIFT.compose(drive()[50][1]).compose(MOUNT)
    assert log.scans[50].reference == pytest.approx(
        Pose(at.x, at.y, math.remainder(at.theta, math.tau)), abs=1e-6
    )


def test_two_topics_of_scans_are_told_and_one_is_chosen(tmp_path: Path) -> None:
    ros = Ros(1)
    messages = messages_of(ros)
    rear = [("/rear", t, message) for topic, t, message in messages if topic == "/scan"][:9]
    path = ros.write(tmp_path / "two.bag", messages + rear)
    with pytest.raises(LogError, match="choose one by --scan-topic"):
        read_ros_bag(path)
    assert len(read_ros_bag(path, RosTopics(scan="/rear")).scans) == 9
    with pytest.raises(LogError, match="no topic /front of"):
        read_ros_bag(path, RosTopics(scan="/front"))


@pytest.mark.parametrize(
    ("left_out", "said"),
    [
        (("/scan",), "no topic of sensor_msgs/msg/LaserScan: it has /odom"),
        (("/odom", "/tf"), "no odometry, neither a topic nor tf"),
    ],
)
def test_bags_without_scans_or_odometry_are_one_line(
    tmp_path: Path, left_out: tuple[str, ...], said: str
) -> None:
    ros = Ros(1)
    messages = [each for each in messages_of(ros) if each[0] not in left_out]
    path = ros.write(tmp_path / "half.bag", messages)
    with pytest.raises(LogError, match=said):
        read_ros_bag(path)


def test_broken_bags_are_one_line(tmp_path: Path) -> None:
    ros = Ros(1)
    whole = ros.write(tmp_path / "whole.bag", messages_of(ros)).read_bytes()
    for number, content in enumerate((b"", b"#ROSBAG V2.0\n", whole[: len(whole) // 2])):
        path = tmp_path / f"broken{number}.bag"
        path.write_bytes(content)
        with pytest.raises(LogError, match="not a readable ROS bag"):
            read_ros_bag(path)


def test_other_files_are_no_bags(tmp_path: Path) -> None:
    for name in ("robot1.mcap", "drive.log.gz"):
        (tmp_path / name).write_bytes(b"\x89MCAP0\r\n" + bytes(40))
        assert not is_ros_bag(tmp_path / name)
    assert not is_ros_bag(tmp_path)

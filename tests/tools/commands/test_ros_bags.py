"""ROS bags through every command that takes logs, and a recording as a ROS 2 bag and back."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from maps.occupancy_map import FREE, OCCUPIED, load_map
from tests.tools.logs.ros_bags import ROOM, Ros, drive, messages_of
from tools.cli import main
from tools.logs.recorded_config import recorded_config
from tools.logs.recorded_scans import recorded_scans
from tools.logs.recording import read_recording

rosbags = pytest.importorskip("rosbags")


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The drive of a robot whose scanner looks over 270 degrees, with its pose in the map."""
    ros = Ros(2)
    folder = tmp_path_factory.mktemp("bag")
    return ros.write(folder / "drive", messages_of(ros, map_frame=True), "MCAP")


@pytest.fixture(scope="module")
def lab(bag: Path) -> Path:
    """The map built from the bag."""
    folder = bag.parent / "lab"
    assert main(["map", "build", str(bag), "-o", str(folder)]) == 0
    return folder


@pytest.fixture(scope="module")
def recording(bag: Path, lab: Path) -> Path:
    """The bag as a recording of device bytes."""
    path = bag.parent / "drive.mcap"
    assert main(["convert", str(bag), "-o", str(path), "--map", str(lab)]) == 0
    return path


def test_a_map_of_a_bag_is_its_room(lab: Path) -> None:
    occupancy = load_map(lab / "map.yaml")
    x0, x1, y0, y1 = ROOM
    walls = int(np.count_nonzero(occupancy.cells == OCCUPIED)) * occupancy.resolution
    assert walls == pytest.approx(2 * (x1 - x0 + y1 - y0), rel=0.35)
    free = int(np.count_nonzero(occupancy.cells == FREE)) * occupancy.resolution**2
    assert free == pytest.approx((x1 - x0) * (y1 - y0), rel=0.1)


def test_a_bag_is_localized_on_its_map(
    bag: Path, lab: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["localize", "--map", str(lab), str(bag)]) == 0
    shown = capsys.readouterr().out
    summary = json.loads(shown[shown.index("{") :])
    assert summary["lost_share"] == 0.0
    assert summary["position_m"]["rmse"] < 0.05


def test_a_bag_becomes_the_bytes_of_an_lms_200(
    recording: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["replay", str(recording), "--check"]) == 0
    capsys.readouterr()
    read = read_recording(recording)
    config, _ = recorded_config(read)
    steps = list(recorded_scans(read, config))
    assert len(steps) >= len(drive()) - 1
    assert config.laser.resolution_deg == 0.5
    assert len(steps[5].points) > 350  # of 361 beams


def test_a_recording_as_a_ros_2_bag_is_read_by_rosbags_and_back(
    recording: Path, tmp_path: Path
) -> None:
    from rosbags.highlevel import AnyReader

    target = tmp_path / "drive.ros2"
    assert main(["convert", str(recording), "-o", str(target)]) == 0
    with AnyReader([target]) as reader:
        counts = {each.topic: each.msgcount for each in reader.connections}
        (grid,) = [
            reader.deserialize(data, connection.msgtype)
            for connection, _, data in reader.messages()
            if connection.topic == "/map"
        ]
    assert set(counts) == {"/scan", "/odom", "/tf", "/tf_static", "/map"}
    assert counts["/scan"] >= len(drive()) - 1
    assert set(np.unique(grid.data)) == {-1, 0, 100}
    assert (grid.info.width, grid.info.height) == load_map(
        recording.parent / "lab" / "map.yaml"
    ).cells.shape[::-1]
    back = tmp_path / "back.mcap"
    lab = recording.parent / "lab"
    assert main(["convert", str(target), "-o", str(back), "--map", str(lab)]) == 0
    first, second = (
        list(recorded_scans(read, recorded_config(read)[0]))
        for read in (read_recording(recording), read_recording(back))
    )
    one, two = first[20], second[20 - (len(first) - len(second))]
    assert one.reference is not None
    assert two.reference is not None
    assert two.reference[:2] == pytest.approx(one.reference[:2], abs=0.02)


def test_an_existing_folder_is_not_overwritten(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    target = tmp_path / "there.ros2"
    target.mkdir()
    assert main(["convert", str(recording), "-o", str(target)]) != 0
    assert "give the name of a new folder" in capsys.readouterr().err

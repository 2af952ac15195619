"""``patrol calibrate laser`` and ``odometry`` on drives of an emulated robot that is otherwise."""

from __future__ import annotations

import math
import re
from pathlib import Path

import pytest

from drivers.lms200.settings import LaserSettings
from drivers.p2os.settings import BaseSettings
from maps.pose import Pose
from robot_agent.config import AgentConfig, load_config
from tests.tools.calibration.driven_by_keys import CORNERS, record_drive, truth_file
from tools.cli import main

MOUNT = Pose(0.055, -0.02, 0.07)
COUNTED = (1.02, 0.985)
"""Way counted over true way of the wheels."""


@pytest.fixture(scope="module")
def drive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("drive")
    truth = truth_file(folder, MOUNT, upside_down=True)
    return record_drive(folder, truth, wheel_scales=COUNTED)


def test_mount_is_found_and_written(
    drive: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    robot = tmp_path / "robot.toml"
    robot.write_text("[laser]\nbaud = 9600  # slow\n")
    assert main(["calibrate", "laser", str(drive), "--robot", str(robot)]) == 0
    laser = load_config(robot).laser
    assert laser.mount is not None
    x, y, theta = laser.mount
    assert (x, y) == pytest.approx(MOUNT[:2], abs=0.01)
    assert theta == pytest.approx(MOUNT.theta, abs=math.radians(0.3))
    assert laser.upside_down
    assert laser.ignore == ()
    assert "# slow" in robot.read_text()
    told = capsys.readouterr()
    assert told.out.startswith("[laser]\nmount = [")
    assert "before" in told.err
    assert "after" in told.err


def test_wheels_and_track_are_found_and_written(drive: Path, tmp_path: Path) -> None:
    robot = tmp_path / "robot.toml"
    assert main(["calibrate", "odometry", str(drive), "--robot", str(robot)]) == 0
    base = load_config(robot).base
    assert base.wheel_scale == pytest.approx([1.0 / scale for scale in COUNTED], rel=0.003)
    assert base.track == pytest.approx(0.3571, rel=0.01)


def test_a_drive_recorded_with_the_calibration_needs_no_other(tmp_path: Path) -> None:
    laser = LaserSettings(mount=tuple(MOUNT), upside_down=True)
    base = BaseSettings(wheel_scale=(1.0 / COUNTED[0], 1.0 / COUNTED[1]))
    config = AgentConfig(laser=laser, base=base)
    truth = truth_file(tmp_path, MOUNT, upside_down=True)
    again = record_drive(tmp_path, truth, wheel_scales=COUNTED, config=config, corners=CORNERS * 2)
    robot = tmp_path / "robot.toml"
    assert main(["calibrate", "odometry", str(again), "--robot", str(robot)]) == 0
    found = load_config(robot).base.wheel_scale
    assert found == pytest.approx([1.0 / scale for scale in COUNTED], rel=0.003)


def test_a_drive_too_short_for_its_slip_says_how_long_a_one_is_needed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    truth = truth_file(tmp_path, MOUNT, upside_down=False, slips=True)
    slipped = record_drive(tmp_path, truth)
    assert main(["calibrate", "odometry", str(slipped)]) == 0
    advice = re.search(
        r"for wheels \+- 0.15 % drive (\d+) m instead of (\d+)", capsys.readouterr().err
    )
    assert advice is not None
    needed, driven = map(int, advice.groups())
    assert driven == pytest.approx(7, abs=1)
    assert 2 * driven < needed < 30 * driven


def test_a_drive_that_turns_one_way_is_refused_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    truth = truth_file(tmp_path, MOUNT, upside_down=False)
    short = record_drive(tmp_path, truth, corners=(1, 1))
    assert main(["calibrate", "laser", str(short)]) == 1
    told = capsys.readouterr()
    assert told.out == ""
    assert len(told.err.strip().splitlines()) == 1
    assert "turn" in told.err

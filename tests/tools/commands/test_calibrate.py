"""Calibration: colours from pictures, direction and focal length from pairs, written in place."""

from __future__ import annotations

import math
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from drivers.camera_source import CameraSettings
from robot_agent.config import ConfigError, load_config
from robot_agent.perception.band_detector import BandDetector
from robot_agent.perception.color_settings import ColorModelSettings, ColorSettings
from tools.calibration.camera_calibration import Pair, fit_camera
from tools.calibration.color_calibration import (
    CalibrationError,
    band_at,
    inside,
    learn_color,
    middle_of,
)
from tools.calibration.config_section import set_keys, with_keys
from tools.cli import main
from tools.simulation.camera_light import Light, LitCamera

GREEN = (60, 220, 70)
BAND = (140, 110, 39, 10)  # left, top, width, height


def picture(color: tuple[int, int, int] = GREEN, light: Light | None = None) -> NDArray[np.uint8]:
    """Return a picture of a room with a band of a colour (BGR) about 2.4 m away."""
    scene = np.empty((240, 320, 3), dtype=np.uint8)
    scene[:120], scene[120:] = (190, 200, 200), (80, 90, 95)
    left, top, width, height = BAND
    scene[top : top + height, left : left + width] = color
    return LitCamera(np.random.default_rng(1)).expose(scene, light or Light(300.0))


def test_learned_colour_finds_its_band_and_no_other(tmp_path: Path) -> None:
    path, robot, mask = tmp_path / "band.png", tmp_path / "robot.toml", tmp_path / "mask.png"
    cv2.imwrite(str(path), picture())
    robot.write_text("# mine\n[robot]\nname = 'anna'\n")
    options = ["--at", "160,115", "--robot", str(robot), "--mask", str(mask)]
    assert main(["calibrate", "color", str(path), *options]) == 0
    config = load_config(robot)
    assert robot.read_text().startswith("# mine\n")
    assert config.robot.name == "anna"
    detector = BandDetector(CameraSettings(), config.perception.color)
    for light in (Light(30.0, 3200.0), Light(1500.0, 6000.0)):
        [blob] = detector.look(picture(light=light)).blobs
        assert blob.bearing == pytest.approx(0.0, abs=0.02)
    assert detector.look(picture((150, 40, 225))).blobs == ()
    shown = cv2.imread(str(mask))
    assert shown is not None
    assert shown.shape == (240, 640, 3)
    assert 250 < np.count_nonzero(shown[:, 320:, 0] > 128) < 700


def test_box_and_middle_mark_the_pixels_inside_them() -> None:
    seen = picture()
    point = band_at(seen, 160, 115)
    assert 250 < np.count_nonzero(point) < 420
    box = middle_of(seen)
    assert np.count_nonzero(inside(seen, box)) == box.width * box.height
    with pytest.raises(CalibrationError, match="outside the picture"):
        band_at(seen, 320, 10)


def test_grey_or_dark_pictures_are_refused() -> None:
    seen = picture()
    wall = np.zeros(seen.shape[:2], dtype=bool)
    wall[10:60, 10:60] = True
    with pytest.raises(CalibrationError, match="grey"):
        learn_color([(seen, wall)])
    with pytest.raises(CalibrationError, match="too dark"):
        learn_color([(np.zeros_like(seen), wall)])


@pytest.mark.parametrize(
    "data", [b"", b"no picture", b"\xff\xd8\xff\xc0\x00\x0b\x08\xff\xdc\xff\xdc" + bytes(8)]
)
def test_what_is_no_picture_or_a_huge_one_is_one_line(
    data: bytes, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "band.jpg"
    path.write_bytes(data)
    assert main(["calibrate", "color", str(path)]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert "band.jpg: is no picture that can be read" in line


def test_direction_and_focal_length_are_found_among_outliers() -> None:
    rng = np.random.default_rng(2)
    theta, focal = 0.07, 231.0
    bearings = rng.uniform(-0.5, 0.6, 80)
    across = -focal * np.tan(bearings - theta) + rng.normal(0.0, 1.5, 80)
    across[:8] += rng.uniform(-60.0, 60.0, 8)
    pairs = [Pair(*pair) for pair in zip(bearings.tolist(), across.tolist(), strict=True)]
    fit = fit_camera(pairs, CameraSettings())
    assert fit.theta == pytest.approx(theta, abs=math.radians(0.4))
    assert fit.focal_length == pytest.approx(focal, rel=0.02)
    assert fit.rms < 3.0


def test_too_few_pairs_or_all_straight_ahead_are_refused() -> None:
    with pytest.raises(CalibrationError, match="needed"):
        fit_camera([Pair(0.1, -20.0)] * 5, CameraSettings())
    with pytest.raises(CalibrationError, match="cross the whole picture"):
        fit_camera([Pair(0.1, -20.0)] * 40, CameraSettings())


def test_sections_are_changed_in_place_or_added() -> None:
    camera = "[camera]\nurl = '/dev/video0'  # front\nmount = [0.0,\n  0.1, 0.0]\n"
    text = camera + "\n[map]\nborder = 'x'\n"
    changed = with_keys(text, "camera", {"mount": [0.1, 0.0, 0.2], "focal_length": 210.0})
    assert "url = '/dev/video0'  # front" in changed
    assert changed.count("mount") == 1
    assert changed.index("focal_length") < changed.index("[map]")
    added = with_keys("[map]\nborder = 'x'\n", "camera", {"focal_length": 210.0})
    assert added.endswith("\n[camera]\nfocal_length = 210.0\n")


def test_file_is_unchanged_if_the_result_is_no_valid_configuration(tmp_path: Path) -> None:
    robot = tmp_path / "robot.toml"
    robot.write_text("[robot]\nname = 'anna'\n")
    with pytest.raises(ConfigError, match=r"camera\.focal_length"):
        set_keys(robot, "camera", {"focal_length": 1.0})
    assert robot.read_text() == "[robot]\nname = 'anna'\n"


def test_default_colour_equals_that_of_the_emulated_robots() -> None:
    seen = picture((150, 40, 225))
    learned = learn_color([(seen, band_at(seen, 160, 115))])
    default = ColorModelSettings()
    assert learned.mean == pytest.approx(default.mean, abs=0.15)
    assert BandDetector(CameraSettings(), ColorSettings()).look(seen).blobs

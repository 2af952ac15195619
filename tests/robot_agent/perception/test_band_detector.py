"""Bands in painted pictures: bearing, range, shape, and unusable pictures."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from drivers.camera_source import CameraSettings
from robot_agent.messages.blob import Blob
from robot_agent.perception.band_detector import BandDetector, judge_sight
from robot_agent.perception.color_settings import ColorSettings
from tools.calibration.color_trial import run_color_trial

CAMERA, COLOR = CameraSettings(), ColorSettings()
MAGENTA = (150, 40, 225)


def room() -> NDArray[np.uint8]:
    picture = np.empty((240, 320, 3), dtype=np.uint8)
    picture[:120], picture[120:] = (190, 200, 200), (80, 90, 95)
    return picture


def put_band(
    picture: NDArray[np.uint8], distance: float, bearing: float, height: float = 0.30
) -> None:
    """Paint a flat band at a distance, m, ahead of the lens, its middle at a height, m."""
    focal = CAMERA.focal_length
    depth = distance * math.cos(bearing)
    x = 159.5 - focal * math.tan(bearing)
    y = 119.5 - focal * (height - CAMERA.mount_height) / depth
    half_width = 0.5 * COLOR.band_width * focal / depth
    half_height = 0.5 * COLOR.band_height * focal / depth
    corners = np.array(((-1, -1), (1, -1), (1, 1), (-1, 1))) * (half_width, half_height) + (x, y)
    cv2.fillConvexPoly(picture, np.rint(corners * 16).astype(np.int32), MAGENTA, shift=4)


def look(picture: NDArray[np.uint8]) -> tuple[Blob, ...]:
    return BandDetector(CAMERA, COLOR).look(picture).blobs


@pytest.mark.parametrize("distance", [0.5, 1.0, 2.0, 2.5])
@pytest.mark.parametrize("bearing", [-0.45, 0.0, 0.3])
def test_bearing_and_range_of_a_band(distance: float, bearing: float) -> None:
    picture = room()
    put_band(picture, distance, bearing)
    [blob] = look(picture)
    if distance > 0.5 or bearing == 0.0:  # else the picture cuts it off
        assert blob.bearing == pytest.approx(bearing, abs=0.012)
    assert abs(blob.range - distance) < 3.0 * blob.range_sigma
    assert distance > 1.0 or abs(blob.range - distance) < 0.15 * distance
    assert blob.elevation == pytest.approx(0.0, abs=0.02)
    assert blob.confidence > 0.5


def test_both_bands_of_a_picture_are_found() -> None:
    picture = room()
    put_band(picture, 1.0, 0.4)
    put_band(picture, 2.0, -0.3)
    ranges = sorted(blob.range for blob in look(picture))
    assert ranges == [pytest.approx(1.0, rel=0.12), pytest.approx(2.0, rel=0.12)]


def test_the_colour_in_the_wrong_place_or_shape_is_no_band() -> None:
    picture = room()
    put_band(picture, 1.0, 0.0, height=0.75)  # a poster at the height of a chest
    cv2.rectangle(picture, (40, 60), (52, 180), MAGENTA, -1)  # a pole
    cv2.rectangle(picture, (150, 118), (310, 124), MAGENTA, -1)  # a stripe along a wall
    assert look(picture) == ()


def test_pictures_of_another_size_are_scaled() -> None:
    picture = room()
    put_band(picture, 1.5, 0.2)
    large = np.asarray(cv2.resize(picture, (640, 480)), dtype=np.uint8)
    [blob] = look(large)
    assert blob.bearing == pytest.approx(0.2, abs=0.012)
    assert blob.range == pytest.approx(1.5, rel=0.1)


@pytest.mark.parametrize(("value", "sight"), [(0, "dark"), (255, "glare"), (120, "covered")])
def test_unusable_pictures_are_classified_and_give_no_bands(value: int, sight: str) -> None:
    picture = np.full((240, 320, 3), value, dtype=np.uint8)
    assert judge_sight(picture) == sight
    assert BandDetector(CAMERA, COLOR).look(picture).blobs == ()
    assert judge_sight(room()) == "clear"


def test_bands_are_found_from_10_to_2000_lux_on_any_background() -> None:
    trial = run_color_trial(120, seed=7)
    assert trial.recall >= 0.95
    assert trial.recall_near >= 0.95
    assert trial.false_share <= 1 / 60  # 2 of 120 pictures
    assert trial.bearing_sigma < 0.012
    assert abs(trial.range_bias) < 0.1
    assert trial.range_sigma < 0.25

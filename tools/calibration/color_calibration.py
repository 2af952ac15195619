"""Fits the team's colour model to pictures of the band."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from robot_agent.perception.color_model import log_chromaticity
from robot_agent.perception.color_settings import ColorModelSettings

LAMP_SIGMA = 0.12
"""Standard deviation added to either coordinate for other lamps, in log chromaticity."""
_MIN_PIXELS = 50
_DARKEST, _BRIGHTEST = 25, 250  # counts of the strongest channel; pixels beyond are not used
_MIN_CHROMA = 0.35  # distance from grey, in log chromaticity
_TRIMMED = 0.1  # share of the pixels, those farthest from the median, that is left out
_POINT_REACH = 12.0  # counts a channel may differ between neighbouring pixels of a band


class CalibrationError(ValueError):
    """The calibration is not possible; the message names reason and remedy."""


@dataclass(frozen=True, slots=True)
class Box:
    """A part of a picture, pixels."""

    left: int
    top: int
    width: int
    height: int


def middle_of(picture: NDArray[np.uint8]) -> Box:
    """Return the middle fifth of a picture each way, where a target is held."""
    rows, columns = picture.shape[:2]
    return Box(columns * 2 // 5, rows * 2 // 5, columns // 5, rows // 5)


def band_at(picture: NDArray[np.uint8], x: int, y: int) -> NDArray[np.bool_]:
    """Return the mask (height, width) of pixels connected to a point in about its colour.

    Raises CalibrationError if the point lies outside the picture.
    """
    rows, columns = picture.shape[:2]
    if not (0 <= x < columns and 0 <= y < rows):
        raise CalibrationError(f"point {x},{y} lies outside the picture of {columns} x {rows}")
    smooth = cv2.GaussianBlur(picture, (5, 5), 1.2)
    mask = np.zeros((rows + 2, columns + 2), dtype=np.uint8)
    reach = (_POINT_REACH,) * 3
    cv2.floodFill(smooth, mask, (x, y), (0, 0, 0), reach, reach, cv2.FLOODFILL_MASK_ONLY | 8)
    return np.asarray(mask[1:-1, 1:-1] > 0)


def inside(picture: NDArray[np.uint8], box: Box) -> NDArray[np.bool_]:
    """Return the mask (height, width) of the pixels in a box.

    Raises CalibrationError if the box is empty or not within the picture.
    """
    rows, columns = picture.shape[:2]
    fits = box.left >= 0 and box.top >= 0 and box.width > 0 and box.height > 0
    if not fits or box.left + box.width > columns or box.top + box.height > rows:
        raise CalibrationError(
            f"box {box.left},{box.top},{box.width},{box.height} does not lie in the picture of "
            f"{columns} x {rows}: give LEFT,TOP,WIDTH,HEIGHT in pixels"
        )
    mask = np.zeros((rows, columns), dtype=np.bool_)
    mask[box.top : box.top + box.height, box.left : box.left + box.width] = True
    return mask


def learn_color(
    samples: Sequence[tuple[NDArray[np.uint8], NDArray[np.bool_]]],
) -> ColorModelSettings:
    """Return the colour model of the marked pixels.

    samples: pictures (height, width, 3), BGR, with masks (height, width). Raises CalibrationError
    if the pixels are too few, too dark, too bright or grey.
    """
    pixels = np.concatenate(
        [np.asarray(cv2.blur(picture, (3, 3)))[mask] for picture, mask in samples]
    )
    strongest = pixels.max(axis=1)
    usable = pixels[(strongest >= _DARKEST) & (strongest <= _BRIGHTEST)]
    if len(usable) < _MIN_PIXELS:
        raise CalibrationError(
            f"{len(usable)} of {len(pixels)} pixels are neither too dark nor too bright, "
            f"{_MIN_PIXELS} are needed: go nearer, or change the light or the exposure"
        )
    places = log_chromaticity(usable)
    off = np.abs(places - np.median(places, axis=0)).max(axis=1)
    kept = places[off <= np.quantile(off, 1.0 - _TRIMMED)]
    mean = kept.mean(axis=0)
    if float(np.hypot(*mean)) < _MIN_CHROMA:
        raise CalibrationError(
            "what is marked is grey: mark the band itself, or choose a stronger colour"
        )
    spread = np.cov(kept.T) + LAMP_SIGMA**2 * np.eye(2)
    return ColorModelSettings(
        mean=(round(float(mean[0]), 4), round(float(mean[1]), 4)),
        covariance=(
            round(float(spread[0, 0]), 5),
            round(float(spread[0, 1]), 5),
            round(float(spread[1, 1]), 5),
        ),
    )

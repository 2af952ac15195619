"""The band detector: finds the bands of the team's colour in a picture."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from drivers.camera_source import CameraSettings
from robot_agent.messages.blob import Blob, Sight
from robot_agent.perception.color_model import ColorTable
from robot_agent.perception.color_settings import ColorSettings

BAND_RANGE = 4.0  # m; blobs beyond it are dropped, and a missing band there is no evidence
MIN_CONFIDENCE = 0.3  # blobs of less are dropped
TILT_ALLOWANCE = 0.06  # rad; one sigma of the camera's pitch with its mounting error
_MIN_AREA = 12  # pixels
_MAX_BLOBS = 8  # largest ones evaluated: bounds the time for a picture full of the colour
_EDGE_SIGMA = 1.0  # pixels; error of an apparent height
_GROWTH = 0.6  # pixels by which blur and coding enlarge the height of a strong colour
_CLOSING = cv2.getStructuringElement(cv2.MORPH_RECT, (5, 3))
_THINNED = 8  # step in rows and columns of the sample that classifies a picture
_DARK, _GLARE = 10.0, 245.0  # counts of the mean
_MIN_CONTRAST = 2.5  # counts, one sigma over the picture


@dataclass(frozen=True, slots=True)
class Look:
    """Result for one picture: its sight, and its bands by descending confidence.

    ``blobs`` is empty unless ``sight`` is "clear".
    """

    sight: Sight
    blobs: tuple[Blob, ...]


@dataclass(frozen=True, slots=True)
class _Region:
    """A connected patch of the mask: its box, pixels, and mean height over its columns (pixels)."""

    left: int
    top: int
    width: int
    height: int
    area: int
    column_height: float


class BandDetector:
    """Finds bands in pictures; stateless, so that it can run on any thread."""

    def __init__(self, camera: CameraSettings, color: ColorSettings) -> None:
        self._camera = camera
        self._color = color
        self._table = ColorTable(color)

    def look(self, picture: NDArray[np.uint8]) -> Look:
        """Return sight and bands of a picture, (height, width, 3) in blue, green, red."""
        sight = judge_sight(picture)
        if sight != "clear":
            return Look(sight, ())
        mask = self.mask(picture)
        blobs = [
            blob
            for region in _regions(mask)
            if (blob := self._blob(region, mask.shape[1], mask.shape[0])) is not None
        ]
        blobs.sort(key=lambda blob: -blob.confidence)
        return Look(sight, tuple(blobs))

    def mask(self, picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Return (height, width): 255 where a pixel has the team's colour, small gaps closed."""
        smooth = np.asarray(cv2.blur(picture, (3, 3)), dtype=np.uint8)
        closed = cv2.morphologyEx(self._table.mask(smooth), cv2.MORPH_CLOSE, _CLOSING)
        return np.asarray(closed, dtype=np.uint8)

    def _blob(self, region: _Region, columns: int, rows: int) -> Blob | None:
        """Return the blob of a region in a picture of (columns, rows); None if it is no band."""
        focal = self._camera.focal_length * columns / self._camera.width
        height = max(region.column_height - _GROWTH, 1.0)
        distance = self._color.band_height * focal / height
        if distance > BAND_RANGE:
            return None
        across = region.left + (region.width - 1) / 2 - (columns - 1) / 2
        down = region.top + (region.height - 1) / 2 - (rows - 1) / 2
        bearing = -math.atan(across / focal)
        # In a flat picture plane objects away from the middle appear larger.
        distance /= math.cos(bearing)
        elevation = -math.atan(down / math.hypot(focal, across))
        confidence = self._confidence(region, columns, distance, elevation, focal)
        if confidence < MIN_CONFIDENCE:
            return None
        return Blob(
            bearing=round(bearing, 6),
            elevation=round(elevation, 6),
            width=round(region.width / focal, 6),
            height=round(height / focal, 6),
            range=round(distance, 6),
            range_sigma=round(0.03 + distance * _EDGE_SIGMA / height, 6),
            confidence=round(confidence, 6),
        )

    def _confidence(
        self, region: _Region, columns: int, distance: float, elevation: float, focal: float
    ) -> float:
        """Return the confidence, 0 to 1, that a region is a band at a distance, m.

        elevation: of its middle, rad. columns, focal: the picture's width and focal length, pixels.
        """
        fill = region.area / (region.width * region.height)
        cut = region.left == 0 or region.left + region.width == columns
        depth = distance * math.cos(math.atan(abs(region.left - columns / 2) / focal))
        width = region.width / focal * depth
        relative = width / self._color.band_width
        # Too wide counts more than too narrow: a band may be partly occluded.
        shape = _bell(math.log(relative), 0.35 if relative > 1.0 else 0.9 if cut else 0.6)
        expected = math.atan((self._color.band_middle - self._camera.mount_height) / distance)
        place = _bell(elevation - expected, TILT_ALLOWANCE)
        return min(fill / 0.8, 1.0) * shape * place


def judge_sight(picture: NDArray[np.uint8]) -> Sight:
    """Return whether a picture is usable: "clear", or why not ("dark", "glare", "covered")."""
    sample = picture[::_THINNED, ::_THINNED].max(axis=2)
    mean = float(sample.mean())
    if mean < _DARK:
        return "dark"
    if mean > _GLARE:
        return "glare"
    return "clear" if float(sample.std()) >= _MIN_CONTRAST else "covered"


def _regions(mask: NDArray[np.uint8]) -> list[_Region]:
    """Return the largest connected patches of a mask (height, width)."""
    count, labels, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
    areas = stats[1:count, cv2.CC_STAT_AREA]
    largest = np.argsort(-areas, kind="stable")[:_MAX_BLOBS] + 1
    regions = []
    for label in largest.tolist():
        left, top, width, height, area = stats[label].tolist()
        if area < _MIN_AREA:
            break
        part = labels[top : top + height, left : left + width] == label
        heights = np.count_nonzero(part, axis=0)
        # The ends of a band are ragged: take the height from its solid columns.
        solid = heights[heights >= 0.5 * heights.max()]
        regions.append(_Region(left, top, width, height, area, float(solid.mean())))
    return regions


def _bell(error: float, sigma: float) -> float:
    return math.exp(-0.5 * (error / sigma) ** 2)

"""Maps of a plan's picture: a scan, a drawing program's export, another program's map."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from maps.image_size import image_size
from maps.input_limits import MAX_CELLS
from maps.occupancy_map import (
    FREE,
    OCCUPIED,
    UNKNOWN,
    MapError,
    OccupancyMap,
    read_map_file,
)
from maps.pose import Pose

_MOST_OUTSIDE = 0.95
"""Share of the free cells that may be outside the building; more: its outline has a gap."""


@dataclass(frozen=True, slots=True, eq=False)
class ImportedMap:
    """A map of a picture; summary: what became of it, for people."""

    map: OccupancyMap
    summary: str


def import_picture(picture: Path, resolution: float, *, dark: float = 0.5) -> ImportedMap:
    """Return the map of a picture, one cell a pixel, its lower-left corner at (0, 0).

    resolution: side of a pixel, m. dark: share of black from which on a pixel is a wall. What is
    transparent is white. Free space that reaches the picture's edge is outside: unknown, if the
    building has a closed outline.

    Raises MapError naming the file and the remedy.
    """
    light = _lightness(read_map_file(picture), str(picture))
    walls = light[::-1] < 1.0 - dark
    if not walls.any():
        raise MapError(f"{picture}: no pixel is darker than {dark:g}: lower --dark")
    cells = np.where(walls, OCCUPIED, FREE).astype(np.uint8)
    outside = _outside(walls)
    share = float(outside.sum() / max((~walls).sum(), 1))
    summary = f"{100.0 * walls.mean():.1f} % walls"
    if share <= _MOST_OUTSIDE:
        cells[outside] = UNKNOWN
        summary += f", {100.0 * outside.mean():.1f} % outside, unknown"
    else:
        summary += "; its outline has a gap, so what is outside counts as free"
    return ImportedMap(OccupancyMap(cells, resolution, Pose(0.0, 0.0, 0.0)), summary)


def _lightness(data: bytes, place: str) -> NDArray[np.float64]:
    """Return (rows, cols) 0 (black) to 1 of a picture of any kind, top row first."""
    size = image_size(data) if data else None
    if size is None:
        raise MapError(f"{place}: not a readable picture (PNG, BMP or PGM), save it as PNG")
    if size[0] * size[1] > MAX_CELLS:
        raise MapError(f"{place}: has {size[0]} x {size[1]} pixels, more than {MAX_CELLS}: crop it")
    try:
        pixels = cv2.imdecode(np.frombuffer(data, dtype=np.uint8), cv2.IMREAD_UNCHANGED)
    except cv2.error:
        pixels = None
    if pixels is None:
        raise MapError(f"{place}: not a readable picture, save it as PNG")
    scaled = pixels.astype(np.float64) / (65535.0 if pixels.dtype == np.uint16 else 255.0)
    if scaled.ndim == 2:
        return np.asarray(scaled)
    solid = scaled[..., 3] if scaled.shape[2] == 4 else np.ones(scaled.shape[:2])
    grey = scaled[..., :3] @ (0.114, 0.587, 0.299)  # blue, green, red: luma of ITU-R BT.601
    return np.asarray(grey * solid + (1.0 - solid))


def _outside(walls: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return (rows, cols) which free cells are joined to the picture's edge."""
    free = np.pad(~walls, 1, constant_values=True).astype(np.uint8)
    _, labels = cv2.connectedComponents(free, connectivity=4)
    return np.asarray(((labels == labels[0, 0]) & (free == 1))[1:-1, 1:-1])

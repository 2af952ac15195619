"""An empty map for an agent that has no map yet."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from maps.map_folder import MapFolder, load_map_folder
from maps.occupancy_map import FREE, OccupancyMap, save_map
from maps.pose import Pose

_CELLS = 8
_RESOLUTION = 0.5  # m


def blank_map() -> MapFolder:
    """Return a map of a few free metres, without a border."""
    cells = np.full((_CELLS, _CELLS), FREE, np.uint8)
    with tempfile.TemporaryDirectory() as parent:
        folder = Path(parent) / "blank"
        save_map(OccupancyMap(cells, _RESOLUTION, Pose(-2.0, -2.0, 0.0)), folder)
        return load_map_folder(folder)

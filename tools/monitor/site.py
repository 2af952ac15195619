"""The monitored site: its map as a picture and its border as a polyline, for the page."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import cv2
import numpy as np

from drivers.p2os.model import DEFAULT_MODEL, load_model
from maps.map_folder import DEFAULT_BORDER, MapFolder, load_map_folder
from maps.map_identity import HASH_SHOWN, identity
from maps.occupancy_map import OccupancyMap
from maps.place_words import PlaceWords
from maps.zone import Zone
from maps.zone_file import load_zones
from robot_agent.messages.streams import ACTIONS
from robot_agent.perception.visibility import VISIBILITY

_BORDER_STEP = 0.1  # m between the points of the line drawn


@dataclass(frozen=True, eq=False)
class Site:
    """A map folder as the page needs it; folder None: no map, the page draws a grid."""

    folder: MapFolder | None
    zones: tuple[Zone, ...] = ()

    @cached_property
    def words(self) -> PlaceWords:
        """What names the site's places in texts."""
        return PlaceWords(self.zones, None if self.folder is None else self.folder.border)

    @cached_property
    def hashes(self) -> tuple[str, str]:
        """The hashes of map and border, as robots report theirs; empty without."""
        files = {} if self.folder is None else self.folder.files
        map_hash, border_hash = identity(files)
        return map_hash[:HASH_SHOWN], border_hash[:HASH_SHOWN]

    def picture(self) -> bytes | None:
        """Return the map as a PNG, top row first: 0 free, 128 unknown, 255 wall; None: no map."""
        return None if self.folder is None else page_picture(self.folder.map)

    def description(self) -> dict[str, object]:
        """Return map, border, footprint and laser mount for the page, m, map frame."""
        model = load_model(DEFAULT_MODEL)
        body = model.body
        shape = {"front": body.front, "rear": body.rear, "halfWidth": 0.5 * body.width}
        result: dict[str, object] = {
            "name": "no map",
            "actions": ACTIONS,
            "visibility": VISIBILITY,
            "robot": shape,
            "laser": list(model.laser_mount),
        }
        if self.folder is None:
            return result
        border = self.folder.border
        result["zones"] = [{"name": zone.name, "polygon": zone.polygon} for zone in self.zones]
        result["name"] = self.folder.name
        result["map"] = page_extent(self.folder.map)
        if border is not None:
            result["border"] = {
                "points": np.round(border.polyline(_BORDER_STEP), 3).tolist(),
                "length": border.length,
                "closed": border.closed,
            }
        return result


def load_site(folder: Path, border: str = DEFAULT_BORDER) -> Site:
    """Read a map folder with its zones.

    Raises MapError, BorderError or ZoneError naming the file.
    """
    return Site(load_map_folder(folder, border), load_zones(folder))


def page_picture(occupancy: OccupancyMap) -> bytes:
    """Return a map as a PNG, top row first: 0 free, 128 unknown, 255 wall."""
    grey = np.array([0, 255, 128], dtype=np.uint8)[occupancy.cells[::-1]]
    return cv2.imencode(".png", grey)[1].tobytes()


def page_extent(occupancy: OccupancyMap) -> dict[str, float]:
    """Return where a map's picture lies: cells, and the lower-left corner, m in the map frame."""
    rows, cols = occupancy.cells.shape
    return {
        "resolution": occupancy.resolution,
        "x": occupancy.origin.x,
        "y": occupancy.origin.y,
        "columns": cols,
        "rows": rows,
    }

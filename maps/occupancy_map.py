"""Occupancy maps: free, occupied and unknown cells, in the ROS ``map_server`` file format.

A map on disk is a YAML file and the grey image it names. Darkness ``p`` of a pixel is
``(255 - value) / 255`` (``value / 255`` with ``negate: 1``); a cell is occupied if
``p > occupied_thresh``, free if ``p < free_thresh``, otherwise unknown. The image's first row is
the map's top. Only ``mode: trinary`` and maps that are not turned (origin yaw 0) are accepted. A
key of ours, ``surface``, which other programs ignore, says where in its cells a wall's surface is.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from maps.image_size import HEAD_BYTES, image_size
from maps.input_limits import MAX_CELLS, MAX_MAP_NUMBER, MAX_RECORD_BYTES, MAX_WORD
from maps.pose import Pose
from maps.whole_file import whole_file
from maps.yaml_text import YamlError, read_yaml

FREE = 0
OCCUPIED = 1
UNKNOWN = 2

# What map_saver writes: read back with its own thresholds, these give the three states again.
_OCCUPIED_THRESH, _FREE_THRESH = 0.65, 0.196
_PIXEL_OF_STATE = np.array([254, 0, 205], dtype=np.uint8)
_GAP = rb"(?:\s+|#[^\n]*\n){1,99}"
_BINARY_PGM = re.compile(rb"P5" + _GAP + rb"\d{1,9}" + _GAP + rb"\d{1,9}" + _GAP + rb"(\d{1,9})\s")
_REQUIRED_KEYS = ("image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh")


class MapError(ValueError):
    """An invalid map; the message names the file, the place and the remedy."""


class Surface(StrEnum):
    """Where the surface of a wall lies, on which the beams of a laser end."""

    FACE = "face"
    """On the faces of the occupied cells: a drawn map, whose walls are solid."""
    CENTRE = "centre"
    """In the occupied cells, on average in the middle: a map built from scans."""


@dataclass(frozen=True, slots=True, eq=False)
class OccupancyMap:
    """A grid of cells in the ``map`` frame.

    cells: (rows, cols) uint8 of FREE, OCCUPIED, UNKNOWN; row 0 is the bottom (smallest y).
    resolution: side of a cell, m. origin: pose of the lower-left corner of cell (0, 0); yaw 0.
    surface: where a wall's surface lies in its cells.

    Raises MapError if any of these does not hold.
    """

    cells: NDArray[np.uint8]
    resolution: float
    origin: Pose
    surface: Surface = Surface.FACE

    def __post_init__(self) -> None:
        if self.cells.ndim != 2 or self.cells.size == 0 or self.cells.dtype != np.uint8:
            raise MapError("a map's cells are a non-empty (rows, cols) array of uint8")
        if self.cells.max() > UNKNOWN:
            raise MapError("a map's cells are 0 (free), 1 (occupied) or 2 (unknown)")
        if not (math.isfinite(self.resolution) and self.resolution > 0.0):
            raise MapError(f"resolution {self.resolution} is not a positive number of metres")
        if not all(math.isfinite(value) for value in self.origin):
            raise MapError(f"origin {list(self.origin)} is not finite")
        if self.origin.theta != 0.0:
            raise MapError(
                f"origin yaw {self.origin.theta:g} rad: turned maps are not supported, "
                "turn the image and set the yaw to 0"
            )

    @property
    def size(self) -> tuple[float, float]:
        """Width and height of the map in m."""
        rows, cols = self.cells.shape
        return cols * self.resolution, rows * self.resolution

    def cells_at(self, points: ArrayLike) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Return (rows, cols), each (n,), of the cells holding points (n, 2) in the map frame.

        Points outside the map give indices outside the grid; see ``inside``.
        """
        xy = np.asarray(points, dtype=np.float64).reshape(-1, 2)
        index = np.floor((xy - self.origin[:2]) / self.resolution).astype(np.intp)
        return index[:, 1], index[:, 0]

    def centre(self, row: int, col: int) -> tuple[float, float]:
        """Return (x, y), m in the map frame, of the centre of a cell."""
        return (
            self.origin.x + (col + 0.5) * self.resolution,
            self.origin.y + (row + 0.5) * self.resolution,
        )

    def centres(self, cells: NDArray[np.intp]) -> NDArray[np.float64]:
        """Return the centres (n, 2), m in the map frame, of cells (n, 2) by row and column."""
        return np.asarray((cells[:, ::-1] + 0.5) * self.resolution + self.origin[:2])

    def inside(self, rows: NDArray[np.intp], cols: NDArray[np.intp]) -> NDArray[np.bool_]:
        """Return (n,) which cells lie in the grid."""
        height, width = self.cells.shape
        return np.asarray((rows >= 0) & (rows < height) & (cols >= 0) & (cols < width))

    def distance_field(self) -> NDArray[np.float32]:
        """Return (rows, cols) distances, m, from each cell's centre to the nearest occupied one's.

        Infinite everywhere on a map without occupied cells.
        """
        occupied = self.cells == OCCUPIED
        return np.asarray(distances_to(occupied) * self.resolution, dtype=np.float32)


def distances_to(chosen: NDArray[np.bool_], step: int = 1) -> NDArray[np.float64]:
    """Return distances, in pixels, from each pixel (rows, cols) to the nearest chosen one.

    step: 2 returns those of every second pixel, the first left out. Infinite if none is chosen.
    """
    taken = slice(step - 1, None, step)
    if not chosen.any():
        return np.full(chosen[taken, taken].shape, np.inf)
    distances = cv2.distanceTransform(
        np.where(chosen, 0, 255).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE
    )[taken, taken]
    # OpenCV's square root differs in the last bit with where the image lies in memory. The
    # square of a distance between pixels is a whole number, which makes it the same everywhere.
    exact = np.sqrt(np.rint(np.square(distances, dtype=np.float64)))
    return np.asarray(exact, dtype=np.float64)


@dataclass(frozen=True, slots=True)
class MapDescription:
    """The content of a map's YAML file, checked."""

    image: str
    resolution: float
    origin: Pose
    negate: bool
    occupied_thresh: float
    free_thresh: float
    surface: Surface


def load_map(yaml_path: Path) -> OccupancyMap:
    """Read a map_server map; the image's path is relative to the YAML file.

    Raises MapError naming the file and the remedy.
    """
    description = read_description(read_map_file(yaml_path), str(yaml_path))
    image_path = yaml_path.parent / description.image
    return assemble_map(description, read_map_file(image_path), str(image_path))


def read_map_file(path: Path) -> bytes:
    """Read one file of a map; raises MapError naming it and the remedy."""
    try:
        return path.read_bytes() if path.stat().st_size <= MAX_RECORD_BYTES else _too_large(path)
    except OSError as error:
        remedy = (
            f"is this a map folder? Shipped maps are {', '.join(shipped_maps())}"
            if path.suffix == ".yaml"
            else "put the image there or correct the key 'image' of the map's YAML file"
        )
        raise MapError(f"{path}: cannot be read ({error.strerror}), {remedy}") from None


def shipped_maps() -> list[str]:
    """Return the names of the maps that come with the product."""
    here = Path(__file__).parent
    return sorted(path.parent.name for path in here.glob("*/map.yaml"))


def _too_large(path: Path) -> bytes:
    raise MapError(f"{path}: has more than {MAX_RECORD_BYTES} bytes: crop or compress it")


def save_map(occupancy: OccupancyMap, folder: Path) -> None:
    """Write ``map.yaml`` and ``map.pgm``, lossless, into a folder, made if absent."""
    pixels = _PIXEL_OF_STATE[occupancy.cells[::-1]]
    rows, cols = pixels.shape
    image = b"P5\n%d %d\n255\n" % (cols, rows) + pixels.tobytes()
    x, y, theta = (float(value) for value in occupancy.origin)
    description = (
        "image: map.pgm\n"
        "mode: trinary\n"
        f"resolution: {_yaml_number(occupancy.resolution)}\n"
        f"origin: [{_yaml_number(x)}, {_yaml_number(y)}, {_yaml_number(theta)}]\n"
        "negate: 0\n"
        f"occupied_thresh: {_OCCUPIED_THRESH}\n"
        f"free_thresh: {_FREE_THRESH}\n"
        f"surface: {occupancy.surface}\n"
    )
    with whole_file(folder / "map.yaml") as described, whole_file(folder / "map.pgm") as drawn:
        described.write_text(description, encoding="utf-8")
        drawn.write_bytes(image)


def read_description(data: bytes, place: str) -> MapDescription:
    """Decode and check a map's YAML text; raises MapError, which names it by ``place``."""
    try:
        content = read_yaml(data)
    except YamlError as error:
        raise MapError(f"{place}: {error}") from None
    if not isinstance(content, dict):
        raise MapError(f"{place}: not a map description, expected 'image: ...' and further keys")
    missing = [key for key in _REQUIRED_KEYS if key not in content]
    if missing:
        raise MapError(f"{place}: key '{missing[0]}' is missing, add it")
    if content.get("mode", "trinary") != "trinary":
        raise MapError(
            f"{place}: mode '{content['mode']!s:.40}' is not supported, only 'trinary' "
            "(free, occupied, unknown); save the map again with mode: trinary"
        )
    description = MapDescription(
        image=_image_name(content["image"], place),
        resolution=_number(content["resolution"], f"{place}: resolution"),
        origin=_origin(content["origin"], place),
        negate=_flag(content["negate"], f"{place}: negate"),
        occupied_thresh=_number(content["occupied_thresh"], f"{place}: occupied_thresh"),
        free_thresh=_number(content["free_thresh"], f"{place}: free_thresh"),
        surface=_surface(content.get("surface", Surface.FACE), place),
    )
    if not 0.0 <= description.free_thresh < description.occupied_thresh <= 1.0:
        raise MapError(
            f"{place}: thresholds must satisfy 0 <= free_thresh < occupied_thresh <= 1, "
            f"got {description.free_thresh:g} and {description.occupied_thresh:g}"
        )
    return description


def assemble_map(description: MapDescription, image: bytes, place: str) -> OccupancyMap:
    """Make a map from its description and its image's bytes; MapError names it by ``place``."""
    pixels = _decode_image(image, place)
    values = np.arange(256)
    darkness = (values if description.negate else 255 - values) / 255.0
    state_of = np.full(256, UNKNOWN, dtype=np.uint8)
    state_of[darkness > description.occupied_thresh] = OCCUPIED
    state_of[darkness < description.free_thresh] = FREE
    try:
        return OccupancyMap(
            state_of[pixels[::-1]],
            description.resolution,
            description.origin,
            description.surface,
        )
    except MapError as error:
        raise MapError(f"{place}: {error}") from None


def _decode_image(data: bytes, place: str) -> NDArray[np.uint8]:
    """Decode a grey 8-bit image, (rows, cols) with the top row first."""
    if not data:
        raise MapError(f"{place}: the image is empty, copy it again")
    size = image_size(data)
    if size is None:
        raise MapError(f"{place}: not a readable image (PGM, PNG or BMP), save it as PGM")
    if size[0] * size[1] > MAX_CELLS:
        raise MapError(
            f"{place}: has {size[0]} x {size[1]} pixels, more than {MAX_CELLS} in all: "
            "crop it, or take a coarser resolution"
        )
    header = _BINARY_PGM.match(data[:HEAD_BYTES])
    if header and int(header[1]) != 255:
        # OpenCV would take such grey values unscaled, and white would turn into grey.
        raise MapError(f"{place}: PGM maximum {int(header[1])} is not supported, save it with 255")
    try:
        pixels = cv2.imdecode(np.frombuffer(data, dtype=np.uint8), cv2.IMREAD_UNCHANGED)
    except cv2.error:
        pixels = None
    if pixels is None:
        raise MapError(f"{place}: not a readable image, save it as PGM")
    if pixels.ndim != 2 or pixels.dtype != np.uint8:
        raise MapError(
            f"{place}: image mode (shape {pixels.shape}, {pixels.dtype}) is not supported, "
            "save it as 8-bit grey without alpha"
        )
    return np.asarray(pixels, dtype=np.uint8)


def _image_name(value: Any, place: str) -> str:
    if not isinstance(value, str) or not 0 < len(value) <= MAX_WORD:
        raise MapError(f"{place}: image must be a file name, got {value!r:.40}")
    return value


def _number(value: Any, what: str) -> float:
    if (
        isinstance(value, bool)
        or not isinstance(value, int | float)
        or not abs(value) <= MAX_MAP_NUMBER
    ):
        raise MapError(f"{what} must be a number, got {value!r:.40}")
    return float(value)


def _flag(value: Any, what: str) -> bool:
    if value not in (0, 1):
        raise MapError(f"{what} must be 0 or 1, got {value!r:.40}")
    return bool(value)


def _surface(value: Any, place: str) -> Surface:
    if value not in tuple(Surface):
        raise MapError(
            f"{place}: surface must be 'face' (a drawn map) or 'centre' (a map built from scans), "
            f"got {value!r:.40}"
        )
    return Surface(value)


def _origin(value: Any, place: str) -> Pose:
    if not isinstance(value, list) or len(value) != 3:
        raise MapError(f"{place}: origin must be [x, y, yaw], got {value!r:.40}")
    origin = Pose(*(_number(item, f"{place}: origin") for item in value))
    if origin.theta != 0.0:
        raise MapError(
            f"{place}: origin yaw {origin.theta:g} rad: turned maps are not supported, "
            "turn the image and set the yaw to 0"
        )
    return origin


def _yaml_number(value: float) -> str:
    """Format a float so that every YAML parser reads a float (1e-05 lacks the point)."""
    text = repr(float(value))
    return text.replace("e", ".0e") if "e" in text and "." not in text else text

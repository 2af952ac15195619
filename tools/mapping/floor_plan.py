"""Maps drawn from a floor plan: walls, doors and furniture listed in a TOML file.

Shapes are drawn in the order walls, doors, furniture: a door clears the wall it is in. All lengths
are in metres in the map frame, angles in degrees::

    resolution = 0.05
    origin = [-1.0, -1.0]                  # lower-left corner of the map
    size = [26.0, 19.0]                    # its width and height
    wall_thickness = 0.15
    floor = [[0.0, 0.0], [24.0, 0.0], [24.0, 17.0], [0.0, 17.0]]   # outline; unknown outside

    [[wall]]                               # a line of walls through these points
    points = [[0.0, 0.0], [24.0, 0.0]]
    [[door]]                               # an opening from one end to the other
    from = [3.0, 0.0]
    to = [3.95, 0.0]
    [[box]]                                # furniture: desks, cabinets
    center = [5.0, 1.0]
    size = [1.6, 0.8]
    angle = 90.0
    [[pillar]]
    center = [10.0, 5.0]
    radius = 0.2
"""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path
from typing import Annotated

import msgspec
import numpy as np
from numpy.typing import NDArray
from shapely import contains_xy
from shapely.geometry import Polygon

from maps.input_limits import MAX_CELLS
from maps.occupancy_map import FREE, OCCUPIED, UNKNOWN, MapError, OccupancyMap, save_map
from maps.pose import Pose
from maps.toml_text import TomlError, read_toml

_Length = Annotated[float, msgspec.Meta(gt=0.0)]
_Point = tuple[float, float]
_Cells = NDArray[np.bool_]


class Wall(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A line of straight walls through points."""

    points: Annotated[list[_Point], msgspec.Meta(min_length=2)]


class Door(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """An opening in a wall, between two points on the wall's middle line."""

    start: _Point = msgspec.field(name="from")
    to: _Point


class Box(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A rectangular piece of furniture."""

    center: _Point
    size: tuple[_Length, _Length]
    angle: float = 0.0  # degrees, counter-clockwise


class Pillar(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A round pillar."""

    center: _Point
    radius: _Length


class FloorPlan(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The content of a floor plan file."""

    resolution: _Length = 0.05
    origin: _Point
    size: tuple[_Length, _Length]
    wall_thickness: _Length
    floor: Annotated[list[_Point], msgspec.Meta(min_length=3)]
    wall: list[Wall] = []
    door: list[Door] = []
    box: list[Box] = []
    pillar: list[Pillar] = []


def load_floor_plan(path: Path) -> FloorPlan:
    """Read a floor plan; raises MapError with the file and the reason."""
    try:
        plan = msgspec.convert(read_toml(path.read_bytes()), FloorPlan)
    except OSError as error:
        raise MapError(f"{path}: cannot read the floor plan ({error.strerror})") from None
    except (msgspec.MsgspecError, TomlError) as error:
        raise MapError(f"{path}: {error}") from None
    width, height = (length / plan.resolution for length in plan.size)
    if not width * height <= MAX_CELLS:
        raise MapError(
            f"{path}: {width:g} x {height:g} cells are more than {MAX_CELLS}: correct size or "
            "resolution"
        )
    return plan


def draw_floor_plan(plan_path: Path, folder: Path) -> OccupancyMap:
    """Draw a floor plan file and write its ``map.yaml`` and ``map.pgm`` into a folder."""
    occupancy = rasterize(load_floor_plan(plan_path))
    save_map(occupancy, folder)
    return occupancy


def rasterize(plan: FloorPlan) -> OccupancyMap:
    """Return the map of a plan; a cell's state is that of its centre."""
    cols, rows = (round(length / plan.resolution) for length in plan.size)
    x, y = np.meshgrid(
        plan.origin[0] + (np.arange(cols) + 0.5) * plan.resolution,
        plan.origin[1] + (np.arange(rows) + 0.5) * plan.resolution,
    )
    solid = np.zeros((rows, cols), dtype=np.bool_)
    half = plan.wall_thickness / 2
    for wall in plan.wall:
        for start, end in pairwise(wall.points):
            solid |= _strip(x, y, start, end, half, overrun=half)
    for door in plan.door:
        # Twice as deep as the wall, so that the opening is free of it.
        solid &= ~_strip(x, y, door.start, door.to, 2.0 * half, overrun=0.0)
    for box in plan.box:
        solid |= _box(x, y, box)
    for pillar in plan.pillar:
        solid |= np.hypot(x - pillar.center[0], y - pillar.center[1]) <= pillar.radius
    cells = np.where(contains_xy(Polygon(plan.floor), x, y), FREE, UNKNOWN).astype(np.uint8)
    cells[solid] = OCCUPIED
    return OccupancyMap(cells, plan.resolution, Pose(*plan.origin, 0.0))


def _strip(
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    start: _Point,
    end: _Point,
    half_width: float,
    *,
    overrun: float,
) -> _Cells:
    """Return the cells in a straight strip from start to end, longer by ``overrun`` at each end."""
    length = math.dist(start, end)
    center = ((start[0] + end[0]) / 2, (start[1] + end[1]) / 2)
    heading = math.atan2(end[1] - start[1], end[0] - start[0])
    return _rectangle(x, y, center, heading, length / 2 + overrun, half_width)


def _box(x: NDArray[np.float64], y: NDArray[np.float64], box: Box) -> _Cells:
    heading = math.radians(box.angle)
    return _rectangle(x, y, box.center, heading, box.size[0] / 2, box.size[1] / 2)


def _rectangle(
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    center: _Point,
    heading: float,
    half_length: float,
    half_width: float,
) -> _Cells:
    """Return the cells in a rectangle turned to a heading, with a margin for rounding."""
    dx, dy = x - center[0], y - center[1]
    along = dx * math.cos(heading) + dy * math.sin(heading)
    across = dy * math.cos(heading) - dx * math.sin(heading)
    hair = 1e-6
    return np.asarray((np.abs(along) <= half_length + hair) & (np.abs(across) <= half_width + hair))

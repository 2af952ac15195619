"""A picture of a map folder: map, border, the direction of s, clearance, and named zones."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from maps.border import Border
from maps.clearance import NEEDED_CLEARANCE, border_clearance
from maps.map_folder import DEFAULT_BORDER, MAP_FILE, MapFolder, load_map_folder
from maps.occupancy_map import OccupancyMap, load_map
from maps.place_words import PlaceWords
from maps.pose import Pose
from maps.whole_file import write_whole
from maps.zone import Zone
from maps.zone_file import load_zones

Color = tuple[int, int, int]

# Blue, green, red.
_STATE_COLORS = np.array([(255, 255, 255), (40, 40, 40), (205, 205, 205)], dtype=np.uint8)
_GRID: Color = (235, 215, 195)
_LABEL: Color = (150, 90, 30)
_ENOUGH_ROOM: Color = (60, 150, 0)
_TOO_NARROW: Color = (0, 0, 220)
_TICK: Color = (190, 0, 120)
_ZONE: Color = (150, 120, 0)

_WIDTH = 1400  # pixels, about
_FONT = cv2.FONT_HERSHEY_SIMPLEX
_GRID_STEP = 5.0  # m
_TICK_STEP = 5.0  # m of abscissa
_FOOT = 40  # pixels below the map for the caption


def draw_map(
    folder: Path, png: Path, border: str = DEFAULT_BORDER, doubts: Sequence[Pose] = ()
) -> None:
    """Write a PNG of a map folder, one of its borders and its zones.

    Green border: enough clearance, red: too little; arrows point along +s, ticks each 5 m of s; a
    circle marks the narrowest place. doubts: places (map_from_laser) to mark in red.

    Raises MapError or BorderError as ``load_map_folder`` does, ZoneError as ``load_zones``; OSError
    if it cannot be written.
    """
    _write(render_map(load_map_folder(folder, border), doubts, load_zones(folder)), png)


def draw_map_alone(folder: Path, png: Path, caption: str) -> None:
    """Write a PNG of a map whose border cannot be read; caption: why. Raises as ``draw_map``."""
    canvas = _Canvas(load_map(folder / MAP_FILE))
    canvas.draw_grid()
    canvas.write(caption, (10, canvas.pixels.shape[0] - 14), _TOO_NARROW, 0.6)
    _write(canvas.pixels, png)


def _write(picture: NDArray[np.uint8], png: Path) -> None:
    write_whole(png, cv2.imencode(".png", picture)[1].tobytes())


def render_map(
    folder: MapFolder, doubts: Sequence[Pose] = (), zones: Sequence[Zone] = ()
) -> NDArray[np.uint8]:
    """Return the picture, (height, width, 3) uint8, blue green red."""
    canvas = _Canvas(folder.map)
    canvas.draw_grid()
    for zone in zones:
        _draw_zone(canvas, zone)
    caption = f"{folder.name}: {folder.map.size[0]:.1f} x {folder.map.size[1]:.1f} m"
    if folder.border is not None:
        told = _draw_border(canvas, folder.map, folder.border)
        caption += PlaceWords(zones, folder.border).explained(told)
    for place in doubts:
        cv2.circle(canvas.pixels, canvas.pixel(place.x, place.y), 8, _TOO_NARROW, 2, cv2.LINE_AA)
    canvas.write(caption, (10, canvas.pixels.shape[0] - 14), _LABEL, 0.6)
    return canvas.pixels


class _Canvas:
    """A picture of a map, drawn on in map coordinates."""

    def __init__(self, occupancy: OccupancyMap) -> None:
        self._scale = max(1, round(_WIDTH / occupancy.cells.shape[1]))
        self._occupancy = occupancy
        top_down = occupancy.cells[::-1].repeat(self._scale, axis=0).repeat(self._scale, axis=1)
        margin = np.full((_FOOT, top_down.shape[1], 3), 255, dtype=np.uint8)
        self.pixels: NDArray[np.uint8] = np.concatenate([_STATE_COLORS[top_down], margin])

    def pixel(self, x: float, y: float) -> tuple[int, int]:
        """Return column and row of a point, m in the map frame."""
        per_metre = self._scale / self._occupancy.resolution
        col = (x - self._occupancy.origin.x) * per_metre
        row = self._occupancy.cells.shape[0] * self._scale
        return round(col), round(row - (y - self._occupancy.origin.y) * per_metre)

    def draw_grid(self) -> None:
        """Draw lines each 5 m of x and y below the walls, and their labels."""
        x0, y0 = self._occupancy.origin[:2]
        width, height = self._occupancy.size
        walls = (self.pixels == _STATE_COLORS[1]).all(axis=2)
        for x in np.arange(np.ceil(x0 / _GRID_STEP) * _GRID_STEP, x0 + width, _GRID_STEP):
            cv2.line(self.pixels, self.pixel(x, y0), self.pixel(x, y0 + height), _GRID, 1)
            self.write(f"{x + 0.0:g}", (self.pixel(x, y0)[0] + 3, 14), _LABEL)
        for y in np.arange(np.ceil(y0 / _GRID_STEP) * _GRID_STEP, y0 + height, _GRID_STEP):
            cv2.line(self.pixels, self.pixel(x0, y), self.pixel(x0 + width, y), _GRID, 1)
            self.write(f"{y + 0.0:g}", (3, self.pixel(x0, y)[1] - 3), _LABEL)
        self.pixels[walls] = _STATE_COLORS[1]

    def write(self, text: str, place: tuple[int, int], color: Color, size: float = 0.42) -> None:
        """Write a text at a column and row."""
        cv2.putText(self.pixels, text, place, _FONT, size, color, 1, cv2.LINE_AA)

    def line(self, points: NDArray[np.float64], color: Color) -> None:
        """Draw a thick line along points (n, 2), m in the map frame."""
        corners = np.array([self.pixel(x, y) for x, y in points], dtype=np.int32)
        cv2.polylines(self.pixels, [corners], False, color, 2, cv2.LINE_AA)


def _draw_zone(canvas: _Canvas, zone: Zone) -> None:
    """Draw a zone's outline, and its name from its upper left corner on."""
    corners = [canvas.pixel(x, y) for x, y in zone.polygon]
    cv2.polylines(canvas.pixels, [np.array(corners)], True, _ZONE, 1, cv2.LINE_AA)
    left, top = min(col for col, _ in corners), min(row for _, row in corners)
    canvas.write(zone.name, (left + 6, top + 18), _ZONE, 0.5)


def _draw_border(canvas: _Canvas, occupancy: OccupancyMap, border: Border) -> str:
    """Draw a border and return its part of the caption."""
    room = border_clearance(occupancy, border)
    points = border.polyline(0.01)
    narrow = room.distances < NEEDED_CLEARANCE
    changes = np.flatnonzero(np.diff(narrow)) + 1
    for part in np.split(np.arange(len(points)), changes):
        # One point more than the part, so that successive parts join.
        piece = points[part[0] : part[-1] + 2]
        canvas.line(piece, _TOO_NARROW if narrow[part[0]] else _ENOUGH_ROOM)
    for s in np.arange(_TICK_STEP / 2, border.length, _TICK_STEP).tolist():
        _draw_arrow(canvas, border, s)
    end = border.length - (_TICK_STEP / 2 if border.closed else 0.0)
    for s in np.arange(0.0, end, _TICK_STEP).tolist():
        _draw_tick(canvas, border, s)
    worst = canvas.pixel(room.narrowest.x, room.narrowest.y)
    color = _TOO_NARROW if room.minimum < NEEDED_CLEARANCE else _LABEL
    cv2.circle(canvas.pixels, worst, 12, color, 2, cv2.LINE_AA)
    canvas.write(f"{room.minimum:.2f} m", (worst[0] + 15, worst[1] + 5), color, 0.5)
    kind = "closed, arrows clockwise" if border.closed else "open"
    return (
        f"; border {border.length:.2f} m ({kind}); least clearance {room.minimum:.2f} m "
        f"at {room.narrowest}"
    )


def _draw_arrow(canvas: _Canvas, border: Border, s: float) -> None:
    point = border.at(s)
    tail = canvas.pixel(point.x - 0.25 * point.tx, point.y - 0.25 * point.ty)
    head = canvas.pixel(point.x + 0.25 * point.tx, point.y + 0.25 * point.ty)
    cv2.arrowedLine(canvas.pixels, tail, head, _ENOUGH_ROOM, 3, cv2.LINE_AA, tipLength=0.7)


def _draw_tick(canvas: _Canvas, border: Border, s: float) -> None:
    point = border.at(s)
    left, right = (
        canvas.pixel(point.x - side * 0.2 * point.ty, point.y + side * 0.2 * point.tx)
        for side in (1.0, -1.0)
    )
    cv2.line(canvas.pixels, left, right, _TICK, 2, cv2.LINE_AA)
    canvas.write(f"s={s:g}", (right[0] + 4, right[1] + 12), _TICK)

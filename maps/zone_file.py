"""Zone files (TOML): ``zones.toml`` in a map folder, for the operator's side; robots ignore it.

Each zone is a polygon of x, y in m in the map frame, in either sense, with a name::

    [[zone]]
    name = "kitchen corridor"
    polygon = [[2.7, 12.5], [16.8, 12.5], [16.8, 15.0], [2.7, 15.0]]
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import msgspec
from shapely import Polygon

from maps.border_primitives import Point
from maps.input_limits import MAX_COORDINATE_M, MAX_ZONE_NAME, MAX_ZONE_VERTICES, MAX_ZONES
from maps.occupancy_map import read_map_file
from maps.toml_text import TomlError, read_toml
from maps.zone import Zone, ZoneError

ZONES_FILE = "zones.toml"

_Name = Annotated[str, msgspec.Meta(min_length=1, max_length=MAX_ZONE_NAME)]
_Polygon = Annotated[list[Point], msgspec.Meta(min_length=3, max_length=MAX_ZONE_VERTICES)]


class ZoneEntry(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One zone of a file."""

    name: _Name
    polygon: _Polygon


class ZoneEntries(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The content of a zone file."""

    zone: Annotated[list[ZoneEntry], msgspec.Meta(max_length=MAX_ZONES)] = []


def load_zones(folder: Path) -> tuple[Zone, ...]:
    """Return the zones of a map folder, none if it has no zone file.

    Raises ZoneError, or MapError for a file that cannot be read.
    """
    path = folder / ZONES_FILE
    return read_zones(read_map_file(path), str(path)) if path.is_file() else ()


def read_zones(data: bytes, place: str) -> tuple[Zone, ...]:
    """Decode a zone file's bytes; raises ZoneError, which names the file by ``place``."""
    try:
        entries = msgspec.convert(read_toml(data), ZoneEntries)
        zones = tuple(Zone(entry.name, tuple(entry.polygon)) for entry in entries.zone)
        _check(zones)
    except (msgspec.MsgspecError, TomlError, ZoneError) as error:
        raise ZoneError(f"{place}: {error}") from None
    return zones


def zones_text(zones: Sequence[Zone]) -> str:
    """Return the content of a zone file."""
    parts = ["# Names of places, for the operator. Metres in the map frame.\n"]
    for zone in zones:
        corners = ", ".join(f"[{x:.3f}, {y:.3f}]" for x, y in zone.polygon)
        name = json.dumps(zone.name, ensure_ascii=False)
        parts.append(f"\n[[zone]]\nname = {name}\npolygon = [{corners}]\n")
    return "".join(parts)


def _check(zones: Sequence[Zone]) -> None:
    names = [zone.name for zone in zones]
    for zone in zones:
        if not zone.name.isprintable() or not zone.name.strip():
            raise ZoneError(f"the name {zone.name!r:.80} has unprintable characters, correct it")
        if names.count(zone.name) > 1:
            raise ZoneError(f"two zones are named '{zone.name}', rename one")
        if any(not abs(number) <= MAX_COORDINATE_M for point in zone.polygon for number in point):
            # NaN comes here too
            raise ZoneError(f"'{zone.name}' has a number beyond {MAX_COORDINATE_M:g} m, correct it")
        shape = Polygon(zone.polygon)
        if not shape.is_valid or shape.area == 0.0:
            raise ZoneError(f"'{zone.name}' is no area: its lines cross or it is flat, correct it")

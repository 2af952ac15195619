"""Upgrades recordings of earlier layouts to the present one: one named step per layout."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from maps.map_identity import identity
from robot_agent.recording.run_header import SCHEMA_VERSION

Fields = dict[str, str]


@dataclass(frozen=True, slots=True)
class Upgrade:
    """Upgrade by one layout. ``step`` takes the header's fields and the map's files."""

    name: str
    step: Callable[[Fields, Mapping[str, bytes]], Fields]


def _identify(fields: Fields, map_files: Mapping[str, bytes]) -> Fields:
    """Add the fields that layout 1 lacks: hashes of map and border, empty versions and boot."""
    map_hash, border_hash = identity(map_files)
    return {**fields, "map_hash": map_hash, "border_hash": border_hash, "versions": "", "boot": ""}


UPGRADES: dict[int, Upgrade] = {
    1: Upgrade("identity of map, border and software", _identify),
    2: Upgrade("decisions with overrides, by today's names", lambda fields, _files: fields),
    3: Upgrade(
        "walls by their faces, teammates by several silhouettes", lambda fields, _files: fields
    ),
}
"""Upgrades by the layout from which they start."""


def upgraded(fields: Fields, map_files: Mapping[str, bytes]) -> tuple[Fields, list[str]]:
    """Return a header's fields in the present layout, and the names of the steps taken."""
    taken = []
    for layout in range(int(fields["schema_version"]), SCHEMA_VERSION):
        upgrade = UPGRADES[layout]
        fields = upgrade.step(fields, map_files)
        taken.append(f"{layout} to {layout + 1}: {upgrade.name}")
    return {**fields, "schema_version": str(SCHEMA_VERSION)}, taken

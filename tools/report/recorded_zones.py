"""The zones of the map in recordings, which carry it without its zones."""

from __future__ import annotations

from pathlib import Path

from maps.border import BorderError
from maps.map_folder import MapFolder, load_map_folder
from maps.map_identity import identity
from maps.occupancy_map import MapError
from maps.zone import Zone
from maps.zone_file import load_zones


def stated_zones(recorded: MapFolder, folder: Path) -> tuple[Zone, ...]:
    """Return the zones of a folder that the user has stated.

    Raises MapError if it is no folder of the recorded map, BorderError or ZoneError if its files
    cannot be read.
    """
    if not _same_map(recorded, folder):
        raise MapError(f"{folder}: is another map than that of the recordings: state theirs")
    return load_zones(folder)


def zones_here(recorded: MapFolder, folder: Path) -> tuple[Zone, ...]:
    """Return the zones of the folder that the recordings name; none if their map is not there.

    Raises ZoneError if the zones cannot be read.
    """
    try:
        return load_zones(folder) if _same_map(recorded, folder) else ()
    except (MapError, BorderError):
        return ()


def _same_map(recorded: MapFolder, folder: Path) -> bool:
    return identity(load_map_folder(folder).files)[0] == identity(recorded.files)[0]

"""Map folders: an occupancy map, its borders, and the bytes of both for a recording.

A folder holds ``map.yaml``, the image it names and one ``<name>.toml`` per border; the default
border is ``border.toml`` and may be absent.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from maps.approach_field import TWO_WHEELED_PIONEER, ApproachField, BodySize
from maps.border import Border, BorderError
from maps.border_file import read_border
from maps.occupancy_map import MapError, OccupancyMap, assemble_map, read_description, read_map_file

DEFAULT_BORDER = "border"
MAP_FILE = "map.yaml"


@dataclass(frozen=True, eq=False)
class MapFolder:
    """An occupancy map, optionally with a border, and their files' bytes.

    name: of the folder. files: name -> content of the files in use (map.yaml, image, border).
    border_name: of the border in use, without ``.toml``.
    """

    name: str
    map: OccupancyMap
    border: Border | None
    files: dict[str, bytes]
    border_name: str = DEFAULT_BORDER

    @cached_property
    def _approach_fields(self) -> dict[tuple[float, float], ApproachField]:
        return {}

    @property
    def approach_field(self) -> ApproachField | None:
        """The paths of a two-wheeled Pioneer, as ``approach_field_of``."""
        return self.approach_field_of(TWO_WHEELED_PIONEER)

    def approach_field_of(self, body: BodySize) -> ApproachField | None:
        """Return the paths of a body to the border round walls, computed once for each size.

        None without a border.
        """
        if self.border is None:
            return None
        size = body.turning_clearance, body.passing_clearance
        if size not in self._approach_fields:
            self._approach_fields[size] = ApproachField(self.map, self.border, body)
        return self._approach_fields[size]


def load_map_folder(folder: Path, border: str = DEFAULT_BORDER) -> MapFolder:
    """Read a map folder and one of its borders.

    Raises MapError or BorderError naming the file, also for a missing border unless it is the
    default one.
    """
    description = read_map_file(folder / MAP_FILE)
    named = read_description(description, str(folder / MAP_FILE)).image
    image = Path(named).name
    if (folder / named).parent.resolve() != folder.resolve():
        # A recording stores the folder's files by name and restores them to one folder.
        raise MapError(
            f"{folder / MAP_FILE}: image '{named}' must lie in the map folder itself: move it there"
        )
    files = {MAP_FILE: description, image: read_map_file(folder / image)}
    border_file = f"{border}.toml"
    if (folder / border_file).is_file():
        files[border_file] = read_map_file(folder / border_file)
    return _assemble(folder.resolve().name, str(folder), files, border)


def map_folder_from_files(
    name: str, files: Mapping[str, bytes], border: str = DEFAULT_BORDER
) -> MapFolder:
    """Make a map folder from its files' bytes, e.g. those in a recording.

    Raises as ``load_map_folder`` does.
    """
    return _assemble(name, name, files, border)


def _assemble(name: str, place: str, files: Mapping[str, bytes], border: str) -> MapFolder:
    if MAP_FILE not in files:
        raise MapError(f"{place}/{MAP_FILE}: missing, a map folder needs one")
    description = read_description(files[MAP_FILE], f"{place}/{MAP_FILE}")
    image = Path(description.image).name
    if image not in files:
        raise MapError(f"{place}/{image}: missing, it is named in {MAP_FILE}")
    occupancy = assemble_map(description, files[image], f"{place}/{image}")
    used = [MAP_FILE, image]
    border_file = f"{border}.toml"
    line = None
    if border_file in files:
        line = read_border(files[border_file], f"{place}/{border_file}")
        used.append(border_file)
    elif border != DEFAULT_BORDER:
        raise BorderError(f"{place}/{border_file}: there is no such border in the map folder")
    return MapFolder(name, occupancy, line, {key: files[key] for key in used}, border)

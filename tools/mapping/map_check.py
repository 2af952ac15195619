"""Check of a map folder before a patrol."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

import numpy as np
from shapely import Polygon, box

from maps.border import Border, BorderError
from maps.clearance import NEEDED_CLEARANCE, border_clearance
from maps.map_folder import DEFAULT_BORDER, MapFolder, load_map_folder
from maps.occupancy_map import OCCUPIED, UNKNOWN, MapError, OccupancyMap
from maps.zone import ZoneError
from maps.zone_file import load_zones
from robot_agent.patrol.settings import PatrolSettings

_MIN_TURNING_RADIUS = PatrolSettings().turning_radius  # m
_MIN_KNOWN_SHARE = 0.05  # of a map's cells
_OVERLAP_M2 = 0.2  # of two zones; less is how people draw edges


@dataclass(frozen=True, slots=True)
class Finding:
    """One line of a map check."""

    subject: str
    ok: bool
    text: str

    def __str__(self) -> str:
        return f"{'ok' if self.ok else 'FAIL':<5}{self.subject}: {self.text}"


@dataclass(frozen=True, slots=True)
class MapReport:
    """The findings of a map check, and the map folder; None if it cannot be read."""

    findings: tuple[Finding, ...]
    content: MapFolder | None = None

    @property
    def ok(self) -> bool:
        """Whether all findings are ok."""
        return all(finding.ok for finding in self.findings)

    def __str__(self) -> str:
        return "\n".join(str(finding) for finding in self.findings)


def check_map(
    folder: Path, border: str = DEFAULT_BORDER, needed: float = NEEDED_CLEARANCE
) -> MapReport:
    """Check that a map folder can be patrolled along one of its borders.

    needed: clearance, m, that the robot needs along it.
    """
    try:
        content = load_map_folder(folder, border)
    except (MapError, BorderError) as error:
        subject = "map" if isinstance(error, MapError) else "border"
        return MapReport((Finding(subject, ok=False, text=str(error)),))
    findings = [*_map_findings(content.map), *_zone_findings(folder, content.map)]
    if content.border is None:
        missing = f"{folder / border}.toml is missing, draw one: patrol map border {folder}"
        return MapReport((*findings, Finding("border", ok=False, text=missing)), content)
    findings += _border_findings(content.map, content.border, needed)
    return MapReport(tuple(findings), content)


def _map_findings(occupancy: OccupancyMap) -> list[Finding]:
    rows, cols = occupancy.cells.shape
    known = float(np.mean(occupancy.cells != UNKNOWN))
    walls = int(np.count_nonzero(occupancy.cells == OCCUPIED))
    return [
        Finding("map", ok=True, text=f"{cols} x {rows} cells of {occupancy.resolution:g} m"),
        Finding("known cells", known >= _MIN_KNOWN_SHARE, f"{100.0 * known:.1f} %"),
        Finding("occupied cells", walls > 0, f"{walls}, a robot finds its place by them"),
    ]


def _zone_findings(folder: Path, occupancy: OccupancyMap) -> list[Finding]:
    """Return the findings on the names of places; none without a zone file."""
    try:
        zones = load_zones(folder)
    except (MapError, ZoneError) as error:
        return [Finding("zones", ok=False, text=str(error))]
    if not zones:
        return []
    width, height = occupancy.size
    x, y = occupancy.origin.x, occupancy.origin.y
    on_map = box(x, y, x + width, y + height)
    shapes = {zone.name: Polygon(zone.polygon) for zone in zones}
    findings = [Finding("zones", ok=True, text=", ".join(shapes))]
    findings += [
        Finding("zone", ok=False, text=f"'{name}' lies outside the map")
        for name, shape in shapes.items()
        if not shape.intersects(on_map)
    ]
    findings += [
        Finding("zone", ok=True, text=f"'{b}' is called '{a}' where both are: first in the file")
        for (a, first), (b, second) in combinations(shapes.items(), 2)
        if first.intersects(second) and first.intersection(second).area > _OVERLAP_M2
    ]
    return findings


def _border_findings(occupancy: OccupancyMap, border: Border, needed: float) -> list[Finding]:
    room = border_clearance(occupancy, border)
    radius = border.tightest_radius
    turning = "no turns" if math.isinf(radius) else f"tightest {radius:.2f} m"
    kind = "closed" if border.closed else "open"
    findings = [
        Finding("border", ok=True, text=f"{border.length:.2f} m, {kind}"),
        Finding(
            "turning radius",
            radius >= _MIN_TURNING_RADIUS,
            f"{turning}, at least {_MIN_TURNING_RADIUS:g} m needed",
        ),
        Finding(
            "clearance",
            room.minimum >= needed,
            f"{room.minimum:.2f} m at {room.narrowest}, at least {needed:g} m needed",
        ),
        *(
            Finding("too narrow", ok=False, text=str(stretch))
            for stretch in room.narrow_stretches(needed)
        ),
    ]
    for where, what in (
        (room.first_outside, "leaves the map"),
        (room.first_unknown, "enters unknown space"),
        (room.first_occupied, "runs through a wall"),
    ):
        if where is not None:
            findings.append(Finding("border", ok=False, text=f"{what} at {where}"))
    return findings

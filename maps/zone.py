"""Zones: parts of a map that people have a name for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from maps.border_primitives import Point


class ZoneError(ValueError):
    """Zones that cannot be used; the message names the file, the zone and the remedy."""


@dataclass(frozen=True, slots=True)
class Zone:
    """A polygon, m in the map frame, with its name; the last vertex is joined to the first."""

    name: str
    polygon: tuple[Point, ...]

    def contains(self, x: float, y: float) -> bool:
        """Return whether a place, m in the map frame, lies in the zone (even-odd rule)."""
        inside = False
        ax, ay = self.polygon[-1]
        for bx, by in self.polygon:
            if (ay > y) != (by > y) and x < ax + (bx - ax) * (y - ay) / (by - ay):
                inside = not inside
            ax, ay = bx, by
        return inside


def zone_name(zones: Sequence[Zone], x: float, y: float) -> str:
    """Return the name of the first zone that a place, m in the map frame, lies in; empty: none."""
    return next((zone.name for zone in zones if zone.contains(x, y)), "")

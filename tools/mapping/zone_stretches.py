"""Which stretches of a border lie in which zone, in words."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

import numpy as np

from maps.border import Border
from maps.place_words import PlaceWords
from maps.zone import Zone

_STEP = 0.1  # m of abscissa


def zone_lines(zones: Sequence[Zone], border: Border | None) -> list[str]:
    """Return a line for each zone: its name, and the abscissae of the border that lie in it."""
    stretches = _stretches(zones, border) if border is not None else {}
    return [
        f"{zone.name}: " + (" and ".join(stretches.get(zone.name, ())) or "none of the border")
        for zone in zones
    ]


def _stretches(zones: Sequence[Zone], border: Border) -> dict[str, list[str]]:
    words = PlaceWords(zones, border)
    points = [border.at(s) for s in np.arange(0.0, border.length, _STEP).tolist()]
    named = [words.zone(point.x, point.y) for point in points]
    found: dict[str, list[str]] = {}
    at = 0
    for name, group in groupby(named):
        end = at + len(list(group))
        found.setdefault(name, []).append(
            f"s = {at * _STEP:.1f} to {min(end * _STEP, border.length):.1f} m"
        )
        at = end
    return found

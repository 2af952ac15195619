"""Names of zones beside every place that a text for the operator tells."""

from __future__ import annotations

import re
from collections.abc import Sequence

from maps.border import Border
from maps.zone import Zone, zone_name

_NUMBER = r"(-?\d{1,7}(?:\.\d{1,4})?)"
_PLACES = re.compile(
    rf"\bs = {_NUMBER} m|\bat {_NUMBER} m of the border|\bat \(?{_NUMBER}, {_NUMBER}(?:\) m|\)| m)"
)
"""Places as the agent's and the monitor's texts tell them: "s = 11.1 m", "at 3.0, 4.0 m"."""


class PlaceWords:
    """Names the places of one site."""

    def __init__(self, zones: Sequence[Zone], border: Border | None) -> None:
        """border: to which ``s`` belongs; None: no s is named."""
        self._zones = zones
        self._border = border

    def zone(self, x: float, y: float) -> str:
        """Return the name of the zone of a place, m in the map frame; empty: of none."""
        return zone_name(self._zones, x, y)

    def explained(self, text: str) -> str:
        """Return a text with the zone in parentheses behind each place that lies in one.

        A zone is not told again for the next place.
        """
        last = ""

        def named(found: re.Match[str]) -> str:
            nonlocal last
            before, last = last, self._zone_of(found)
            return f"{found[0]} ({last})" if last not in ("", before) else found[0]

        return _PLACES.sub(named, text) if self._zones else text

    def placed(self, text: str, place: tuple[float, float] | None) -> str:
        """Return a text with the zones of its places, or of a place if it tells none.

        place: m in the map frame; None: unknown.
        """
        if not self._zones or place is None or _PLACES.search(text):
            return self.explained(text)
        zone = self.zone(*place)
        return f"{text} ({zone})" if zone else text

    def _zone_of(self, found: re.Match[str]) -> str:
        s = found[1] or found[2]
        if s is None:
            return self.zone(float(found[3]), float(found[4]))
        if self._border is None:
            return ""
        point = self._border.at(float(s))
        return self.zone(point.x, point.y)

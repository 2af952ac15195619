"""Where and when an intruder was last seen, and the picture of it."""

from __future__ import annotations

import base64
import binascii
import math
from dataclasses import dataclass, replace

from robot_agent.messages.streams import IntruderPayload
from robot_agent.perception.jpeg import is_shown

_MOVED_M = 0.5
_LATER_S = 1.0


@dataclass(frozen=True, slots=True)
class Sighting:
    """One robot's last sighting of one intruder."""

    x: float  # m, map frame
    y: float
    wall: float  # time it was told, s since 1970
    picture: bytes = b""  # JPEG; empty: none yet

    @property
    def place(self) -> tuple[float, float]:
        """Its place, m, map frame."""
        return self.x, self.y

    def news_after(self, before: Sighting | None) -> bool:
        """Return whether a person who knows an earlier sighting would want this one."""
        if before is None or (self.picture and self.picture != before.picture):
            return True
        moved = math.dist(self.place, before.place)
        return moved > _MOVED_M or self.wall - before.wall >= _LATER_S

    def after(self, before: Sighting | None) -> Sighting:
        """Return this sighting with the picture of an earlier one if it has none of its own."""
        return self if self.picture or before is None else replace(self, picture=before.picture)


def sighting_of(payload: IntruderPayload, wall: float) -> Sighting:
    """Return the sighting that a payload received at wall, s since 1970, tells.

    A picture that is no JPEG, or claims to be huge, is left out.
    """
    return Sighting(payload.x, payload.y, wall, _picture(payload.picture))


def _picture(text: str) -> bytes:
    try:
        data = base64.b64decode(text, validate=True)
    except (binascii.Error, ValueError):
        return b""
    return data if is_shown(data) else b""

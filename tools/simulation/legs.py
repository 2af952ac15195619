"""The two legs of a person in the simulated world, which swing as it walks."""

from __future__ import annotations

import math
from dataclasses import replace

from tools.simulation.silhouette import Silhouette, silhouette_of

_APART = 0.22  # m between the middles of the legs; ours
_SWING = 0.25  # m that each leg goes ahead of and behind the body; ours
_STEP = 0.7  # m walked in half a period; ours
_SIDES = 6  # of a leg's cross-section


class Legs:
    """Two legs as lasers see them, after a distance walked."""

    def __init__(self, width: float) -> None:
        corners = [
            (width / 2 * math.cos(turn), width / 2 * math.sin(turn))
            for turn in (math.tau * number / _SIDES for number in range(_SIDES))
        ]
        self._leg = silhouette_of(corners)

    def at(self, walked: float) -> tuple[Silhouette, ...]:
        """Return the silhouettes, base_link, of a person that has walked so far, m."""
        ahead = _SWING * math.sin(math.pi * walked / _STEP)
        return tuple(
            replace(
                self._leg, middle=self._leg.middle._replace(x=side * ahead, y=side * _APART / 2)
            )
            for side in (-1.0, 1.0)
        )

"""How long a robot has been held at one place."""

from __future__ import annotations

import math


class HeldAtPlace:
    """Counts the time a robot has got no farther than a radius from where it was first held."""

    def __init__(self, radius: float, pause: float = math.inf) -> None:
        """radius: m. pause: s without an update after which the count starts anew."""
        self._radius = radius
        self._pause = pause
        self._place = (math.inf, math.inf)
        self._since = -math.inf
        self._latest = -math.inf

    def update(self, t: float, position: tuple[float, float]) -> float:
        """Return how long, s, the robot has been held at t, s, at a position, m in the map."""
        moved = math.dist(position, self._place) > self._radius
        if moved or t - self._latest > self._pause:
            self.restart(t, position)
        self._latest = t
        return t - self._since

    def restart(self, t: float, position: tuple[float, float]) -> None:
        """Count from t, s, which may lie ahead, at a position."""
        self._since, self._place = t, position

    def forget(self) -> None:
        """Start anew at the next update."""
        self._place = (math.inf, math.inf)

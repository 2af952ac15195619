"""Timer of how long a robot has been held at one place."""

from __future__ import annotations

import math


class HeldAtPlace:
    """Measures for how long a robot has stayed within a radius of where it was first held."""

    def __init__(self, radius: float, pause: float = math.inf) -> None:
        """radius: m. pause: s without an update after which the timer starts again."""
        self._radius = radius
        self._pause = pause
        self._place = (math.inf, math.inf)
        self._since = -math.inf
        self._latest = -math.inf

    def update(self, t: float, position: tuple[float, float]) -> float:
        """Return for how long, s, the robot has been held, at t and a position, m, map frame."""
        moved = math.dist(position, self._place) > self._radius
        if moved or t - self._latest > self._pause:
            self.restart(t, position)
        self._latest = t
        return t - self._since

    def restart(self, t: float, position: tuple[float, float]) -> None:
        """Start the timer at t, which may lie in the future, at a position, m, map frame."""
        self._since, self._place = t, position

    def forget(self) -> None:
        """Reset: the timer starts at the next update."""
        self._place = (math.inf, math.inf)

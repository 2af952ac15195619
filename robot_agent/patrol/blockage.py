"""An object on the border that is no teammate: after a while the robot stops waiting for it."""

from __future__ import annotations

import math

from robot_agent.patrol.settings import PatrolSettings

_MOVED = 0.15  # m; a robot that got so far is not held at one place
_PAUSE = 1.0  # s without being held that end it; the gate's noise is shorter


class Blockage:
    """Watches how long obstacles have held the robot at one place."""

    def __init__(self, settings: PatrolSettings) -> None:
        self._settings = settings
        self._since: float | None = None
        self._last_held = -math.inf
        self._place = (0.0, 0.0)

    def ends_waiting(
        self, t: float, position: tuple[float, float], distance_from_neighbor: float, *, held: bool
    ) -> bool:
        """Tell, once per blockage_time, whether an object has held the robot so long.

        t in s, position (x, y) in m in the map frame. held: the safety gate let the robot not
        drive for an obstacle. A teammate near by may be that obstacle, and is waited for.
        """
        if distance_from_neighbor < self._settings.blockage_neighbor_distance:
            self._since = None
        elif held:
            moved = math.dist(position, self._place) > _MOVED
            if self._since is None or moved or t - self._last_held > _PAUSE:
                self._since, self._place = t, position
            self._last_held = t
            if t - self._since >= self._settings.blockage_time:
                self._since = None
                return True
        return False

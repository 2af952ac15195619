"""Robots that keep each other from the border: after a while one insists on its way there.

Not in the paper, whose rules remember nothing: a robot beside the border that avoids a teammate on
it, who turns back and comes again, would wait for ever, and so would one whom a door post keeps
from patrolling along. It takes Reach Frontier for a while instead: round walls, and with the safety
gate's distance from everybody. The teammates see it come, and give way by the paper's rules.
"""

from __future__ import annotations

import math

from robot_agent.patrol.actions import Action
from robot_agent.patrol.settings import PatrolSettings

_STANDS = 0.3  # m; a robot that got no farther is still at the same place
_ON_BORDER = 0.3  # m; nearer, it has arrived


class Standoff:
    """Watches how long the robot has got nowhere beside the border."""

    def __init__(self, settings: PatrolSettings) -> None:
        self._settings = settings
        self._place = (math.inf, math.inf)
        self._since = -math.inf  # s, at that place
        self._avoids_since: float | None = None
        self._insists_until = -math.inf

    def insists(
        self, t: float, position: tuple[float, float], way_to_border: float, action: Action
    ) -> bool:
        """Tell whether Reach Frontier takes the place of an action at t, s.

        position: (x, y) in the map, m. way_to_border: round walls, m.
        """
        if way_to_border < _ON_BORDER:
            self._begin(t, position)
            self._avoids_since = None
            self._insists_until = -math.inf
            return False
        if t < self._insists_until:
            return True
        if action is not Action.AVOID_TEAMMATE:
            self._avoids_since = None
        elif self._avoids_since is None:
            self._avoids_since = t
        reaches = action is Action.REACH_FRONTIER
        if reaches or math.dist(position, self._place) > _STANDS:
            self._begin(t, position)
        settings = self._settings
        stands = t - self._since >= settings.standoff_time
        avoids = self._avoids_since is not None and (
            t - self._avoids_since >= settings.longest_avoiding
        )
        if not (stands or avoids):
            return False
        self._begin(t + settings.insisting_time, position)
        self._avoids_since = None
        self._insists_until = t + settings.insisting_time
        return True

    def _begin(self, t: float, position: tuple[float, float]) -> None:
        self._since, self._place = t, position

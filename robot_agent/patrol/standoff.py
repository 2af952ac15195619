"""Robots that keep each other from patrolling: after a while one insists on its way.

Not in the paper, whose rules remember nothing: a robot beside the border that avoids a teammate on
it, who turns back and comes again, would wait for ever, and so would one whom a door post keeps
from patrolling along. It takes Reach Frontier for a while instead: round walls, and with the safety
gate's distance from everybody. On the border itself, among robots on either side, it is Keep Going
that ends long avoiding. One that stands caught between an end of the border and a teammate, who
will not move any more, takes the way out until somebody has to be avoided. The teammates see it
come, and give way by the paper's rules.
"""

from __future__ import annotations

import math

from robot_agent.patrol.actions import Action
from robot_agent.patrol.settings import PatrolSettings

_STANDS = 0.3  # m; a robot that got no farther is still at the same place
_ON_BORDER = 0.3  # m; nearer, it has arrived


class Standoff:
    """Watches how long the robot has got nowhere beside the border, or avoided or stood on it."""

    def __init__(self, settings: PatrolSettings) -> None:
        self._settings = settings
        self._place = (math.inf, math.inf)
        self._since = -math.inf  # s, at that place
        self._avoids_since: float | None = None
        self._insists_until = -math.inf
        self._on_border = False
        self._way_out: Action | None = None  # that it insists on

    def insists_on(
        self,
        t: float,
        position: tuple[float, float],
        way_to_border: float,
        action: Action,
        way_out: Action | None = None,
    ) -> Action | None:
        """Return what takes the place of an action at t, s; None: nothing, the action stands.

        position: (x, y) in the map, m. way_to_border: round walls, m. way_out: what leads away
        from the end, of a robot caught there.
        """
        on_border = way_to_border < _ON_BORDER
        if on_border and not self._on_border:
            self._insists_until = -math.inf
        self._on_border = on_border
        if self._way_out is not None and action is Action.AVOID_TEAMMATE:
            self._insists_until = -math.inf
        if t < self._insists_until:
            return self._insisted()
        if action is not Action.AVOID_TEAMMATE:
            self._avoids_since = None
        elif self._avoids_since is None:
            self._avoids_since = t
        reaches = action is Action.REACH_FRONTIER
        if (on_border and way_out is None) or reaches or math.dist(position, self._place) > _STANDS:
            self._begin(t, position)
        settings = self._settings
        stands = t - self._since >= settings.standoff_time
        avoids = self._avoids_since is not None and (
            t - self._avoids_since >= settings.longest_avoiding
        )
        if not (stands or avoids):
            return None
        self._begin(t + settings.insisting_time, position)
        self._avoids_since = None
        self._insists_until = t + settings.insisting_time
        self._way_out = way_out
        return self._insisted()

    def _insisted(self) -> Action:
        if self._way_out is not None:
            return self._way_out
        return Action.KEEP_GOING if self._on_border else Action.REACH_FRONTIER

    def _begin(self, t: float, position: tuple[float, float]) -> None:
        self._since, self._place = t, position

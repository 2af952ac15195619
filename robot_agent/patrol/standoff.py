"""Robots that keep each other from patrolling: after a while one insists on its way.

Not in the paper, whose rules remember nothing: a robot beside the border that avoids a teammate on
it, who turns back and comes again, would wait for ever, and so would one that a door post keeps
from patrolling along. It takes Reach Frontier for a while instead: round walls, and with the safety
gate's distance from everybody. On the border itself, among robots on either side, it is Keep Going
that ends long avoiding. A robot caught between an end of the border and a teammate that does not
move any more takes the way out, slowly, until it has to avoid. The teammates see it come and give
way by the paper's rules.
"""

from __future__ import annotations

import math

from robot_agent.patrol.actions import Action
from robot_agent.patrol.end_trap import way_out
from robot_agent.patrol.held_at_place import HeldAtPlace
from robot_agent.patrol.modifier import Override, OverrideReason
from robot_agent.patrol.situation import Situation
from robot_agent.patrol.supervisor import Choice

_PATIENCE = 12.0  # s beside the border, or caught at its end, until it insists
_STANDS = 0.3  # m; a robot that got no farther is still at the same place
_ON_BORDER = 0.3  # m; nearer, it has arrived
_LONGEST_AVOIDING = 20.0  # s of Avoid Teammate, wherever it leads
_INSISTING = 8.0  # s
_WAY_OUT_SPEED = 0.2  # m/s


class Standoff:
    """Overrides the action of a robot that got nowhere, or avoided, for long."""

    def __init__(self) -> None:
        self._held = HeldAtPlace(_STANDS)
        self._avoids_since: float | None = None
        self._insists_until = -math.inf
        self._on_border = False
        self._way_out: Action | None = None  # that it insists on

    def propose(self, situation: Situation, choice: Choice, action: Action) -> Override | None:
        """Insist on the way to the border, along it, or out of an end, for some seconds."""
        t, out = situation.t, way_out(situation, choice)
        self._end_insisting(situation, action)
        if t < self._insists_until:
            return self._insisting()
        stands, avoids = self._stands(situation, action, out), self._avoids(t, action)
        if not (stands or avoids):
            return None
        self._held.restart(t + _INSISTING, situation.position)
        self._avoids_since = None
        self._insists_until = t + _INSISTING
        self._way_out = out
        return self._insisting()

    def _end_insisting(self, situation: Situation, action: Action) -> None:
        """Stop at the border, and on the way out where somebody has to be avoided."""
        on_border = situation.way_to_border < _ON_BORDER
        arrived = on_border and not self._on_border
        self._on_border = on_border
        if arrived or (self._way_out is not None and action is Action.AVOID_TEAMMATE):
            self._insists_until = -math.inf

    def _stands(self, situation: Situation, action: Action, out: Action | None) -> bool:
        """Tell whether it got nowhere for too long; on the border only a robot caught there."""
        free = self._on_border and out is None
        if free or action is Action.REACH_FRONTIER:
            self._held.restart(situation.t, situation.position)
        return self._held.update(situation.t, situation.position) >= _PATIENCE

    def _avoids(self, t: float, action: Action) -> bool:
        if action is not Action.AVOID_TEAMMATE:
            self._avoids_since = None
        elif self._avoids_since is None:
            self._avoids_since = t
        return self._avoids_since is not None and t - self._avoids_since >= _LONGEST_AVOIDING

    def _insisting(self) -> Override:
        if self._way_out is not None:
            return Override(OverrideReason.STANDOFF, self._way_out, speed_limit=_WAY_OUT_SPEED)
        action = Action.KEEP_GOING if self._on_border else Action.REACH_FRONTIER
        return Override(OverrideReason.STANDOFF, action)

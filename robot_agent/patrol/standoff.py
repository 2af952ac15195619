"""Modifier ``standoff``: resolve deadlocks of robots that keep each other from patrolling.

Not in the paper, whose rules have no memory: a robot beside the border that avoids a teammate which
patrols to and fro there would wait for ever, and so would one that a door post keeps from the
border. After a timeout Reach Frontier replaces its action for a while: round walls, and with the
safety gate's distance from obstacles. On the border itself, between robots on either side, Keep
Going replaces long avoiding. A robot caught between an end of the border and a teammate that no
longer moves patrols slowly away from the end until it has to avoid. The teammates give way by the
paper's rules.
"""

from __future__ import annotations

import math

from robot_agent.patrol.actions import Action
from robot_agent.patrol.end_trap import way_out
from robot_agent.patrol.held_at_place import HeldAtPlace
from robot_agent.patrol.modifier import Override, OverrideReason
from robot_agent.patrol.situation import Situation
from robot_agent.patrol.supervisor import Choice

HELD_TIMEOUT = 12.0  # s at one place beside the border, or caught at its end
SAME_PLACE = 0.3  # m; a robot that has moved less is still at the same place
ON_BORDER = 0.3  # m; a robot nearer has reached the border
AVOIDING_TIMEOUT = 20.0  # s of Avoid Teammate, moving or not
DURATION = 8.0  # s of an override
WAY_OUT_SPEED = 0.2  # m/s


class Standoff:
    """Overrides the action of a robot that was held, or has avoided teammates, for a timeout."""

    def __init__(self) -> None:
        self._held = HeldAtPlace(SAME_PLACE)
        self._avoiding_since: float | None = None
        self._active_until = -math.inf
        self._on_border = False
        self._way_out: Action | None = None  # of the present override, if at an end

    def propose(self, situation: Situation, choice: Choice, action: Action) -> Override | None:
        """Return the override while one is active: to the border, along it, or out of an end."""
        t, out = situation.t, way_out(situation, choice)
        self._end_if_done(situation, action)
        if t < self._active_until:
            return self._override()
        held, avoiding = self._is_held(situation, action, out), self._avoids_too_long(t, action)
        if not (held or avoiding):
            return None
        self._held.restart(t + DURATION, situation.position)
        self._avoiding_since = None
        self._active_until = t + DURATION
        self._way_out = out
        return self._override()

    def _end_if_done(self, situation: Situation, action: Action) -> None:
        """End the override on arrival at the border, or if a way out leads to a teammate."""
        on_border = situation.way_to_border < ON_BORDER
        arrived = on_border and not self._on_border
        self._on_border = on_border
        if arrived or (self._way_out is not None and action is Action.AVOID_TEAMMATE):
            self._active_until = -math.inf

    def _is_held(self, situation: Situation, action: Action, out: Action | None) -> bool:
        """Return whether the robot was held for the timeout; on the border only if caught there."""
        free = self._on_border and out is None
        if free or action is Action.REACH_FRONTIER:
            self._held.restart(situation.t, situation.position)
            return False
        return self._held.update(situation.t, situation.position) >= HELD_TIMEOUT

    def _avoids_too_long(self, t: float, action: Action) -> bool:
        if action is not Action.AVOID_TEAMMATE:
            self._avoiding_since = None
        elif self._avoiding_since is None:
            self._avoiding_since = t
        return self._avoiding_since is not None and t - self._avoiding_since >= AVOIDING_TIMEOUT

    def _override(self) -> Override:
        if self._way_out is not None:
            return Override(OverrideReason.STANDOFF, self._way_out, speed_limit=WAY_OUT_SPEED)
        action = Action.KEEP_GOING if self._on_border else Action.REACH_FRONTIER
        return Override(OverrideReason.STANDOFF, action)

"""Modifier ``standoff`` for many robots at once."""

from __future__ import annotations

import math

import numpy as np

from robot_agent.patrol import standoff
from robot_agent.patrol.modifier import OverrideReason
from tools.batch.arbiters import Choices
from tools.batch.arrays import Codes, Indices, pick
from tools.batch.ends import ways_out
from tools.batch.held_places import HeldPlaces
from tools.batch.situations import NONE, Act, Overrides, Situations


class Standoffs:
    """Overrides the actions of robots that were held, or have avoided teammates, for a timeout."""

    def __init__(self, n: int) -> None:
        self._held = HeldPlaces(n, standoff.SAME_PLACE)
        self._avoiding_since = np.full(n, math.inf)
        self._active_until = np.full(n, -math.inf)
        self._on_border = np.zeros(n, dtype=np.bool_)
        self._way_out = np.full(n, NONE, dtype=np.int8)

    def propose(self, at: Situations, choices: Choices, action: Codes, found: Overrides) -> Indices:
        """Put the active overrides: to the border, along it, or out of an end."""
        out = ways_out(at, choices)
        self._end_if_done(at, action)
        waiting = at.t >= self._active_until
        triggered = self._is_held(at, action, out, waiting)
        avoids = waiting & (action == Act.AVOID_TEAMMATE)
        self._avoiding_since[waiting & ~avoids] = math.inf
        if avoids.any():
            begins = avoids & (self._avoiding_since == math.inf)
            self._avoiding_since[begins] = at.t
            triggered |= avoids & (at.t - self._avoiding_since >= standoff.AVOIDING_TIMEOUT)
        new = triggered.nonzero()[0]
        if new.size:
            self._held.restart(new, at.t + standoff.DURATION, at.x, at.y)
            self._avoiding_since[new] = math.inf
            self._active_until[new] = at.t + standoff.DURATION
            self._way_out[new] = out[new]
        active = (at.t < self._active_until).nonzero()[0]
        if active.size:
            self._override(active, found)
        return active

    def pick(self, robots: Indices) -> None:
        """Keep some robots, as ``arrays.pick`` does."""
        pick(self, ("_avoiding_since", "_active_until", "_on_border", "_way_out"), robots)
        self._held.pick(robots)

    def _end_if_done(self, at: Situations, action: Codes) -> None:
        on_border = at.way < standoff.ON_BORDER
        arrived = on_border & ~self._on_border
        self._on_border = on_border
        arrived |= (self._way_out != NONE) & (action == Act.AVOID_TEAMMATE)
        self._active_until[arrived] = -math.inf

    def _is_held(
        self, at: Situations, action: Codes, out: Codes, waiting: np.ndarray
    ) -> np.ndarray:
        """Return (n,) which robots were held for the timeout; on the border only if caught."""
        free = (self._on_border & (out == NONE)) | (action == Act.REACH_FRONTIER)
        self._held.restart((waiting & free).nonzero()[0], at.t, at.x, at.y)
        triggered = np.zeros(len(free), dtype=np.bool_)
        some = (waiting & ~free).nonzero()[0]
        if some.size:
            triggered[some] = self._held.update(some, at.t, at.x, at.y) >= standoff.HELD_TIMEOUT
        return triggered

    def _override(self, some: Indices, found: Overrides) -> None:
        way_out = self._way_out[some]
        inside = np.where(self._on_border[some], Act.KEEP_GOING, Act.REACH_FRONTIER)
        caught = way_out != NONE
        found.put(
            some,
            OverrideReason.STANDOFF,
            action=np.where(caught, way_out, inside).astype(np.int8),
            speed_limit=np.where(caught, standoff.WAY_OUT_SPEED, math.inf),
        )

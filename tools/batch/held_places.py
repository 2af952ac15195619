"""``HeldAtPlace`` for many robots at once."""

from __future__ import annotations

import math

import numpy as np

from tools.batch.arrays import Indices, Reals, pick


class HeldPlaces:
    """Measures for how long each robot has stayed within a radius of where it was first held."""

    def __init__(self, n: int, radius: float, pause: float = math.inf) -> None:
        """radius: m. pause: s without an update after which a timer starts again."""
        self._radius = radius
        self._pause = pause
        self._x = np.full(n, math.inf)
        self._y = np.full(n, math.inf)
        self._since = np.full(n, -math.inf)
        self._latest = np.full(n, -math.inf)

    def update(self, some: Indices, t: float, x: Reals, y: Reals) -> Reals:
        """Return for how long, s, some robots have been held, at t and positions of all, m."""
        px, py = x[some], y[some]
        moved = np.hypot(px - self._x[some], py - self._y[some]) > self._radius
        if self._pause < math.inf:
            moved |= t - self._latest[some] > self._pause
            self._latest[some] = t
        new = some[moved]
        self.restart(new, t, x, y)
        return np.asarray(t - self._since[some])

    def pick(self, robots: Indices) -> None:
        """Keep some robots, as ``arrays.pick`` does."""
        pick(self, ("_x", "_y", "_since", "_latest"), robots)

    def restart(self, some: Indices, t: float, x: Reals, y: Reals) -> None:
        """Start timers at t, which may lie in the future, at the robots' positions."""
        self._since[some] = t
        self._x[some] = x[some]
        self._y[some] = y[some]

    def forget(self, some: Indices) -> None:
        """Reset: the timers start at the next update."""
        self._x[some] = math.inf

"""``RandomReversal`` for many robots at once."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from robot_agent.patrol.reversal import interval
from robot_agent.patrol.settings import PatrolSettings
from tools.batch.arrays import Flags, Indices, Reals, pick


class Reversals:
    """Schedules the times at which each robot may turn back, each with some probability."""

    def __init__(self, settings: PatrolSettings, rngs: Sequence[np.random.Generator]) -> None:
        self._settings = settings
        self._rngs = rngs
        self._next: Reals = np.full(len(rngs), math.nan)

    def due(self, t: float, permitted: Flags) -> Indices:
        """Return the robots that turn back at t; a time that passes unpermitted is lost."""
        settings = self._settings
        for robot in np.flatnonzero(np.isnan(self._next)).tolist():
            first = float(self._rngs[robot].uniform(0.0, settings.reversal_period))
            self._next[robot] = t + first
        turning = []
        for robot in (t >= self._next).nonzero()[0].tolist():
            rng = self._rngs[robot]
            while self._next[robot] <= t:
                self._next[robot] += interval(
                    settings.reversal_period, settings.reversal_distribution, rng
                )
            if permitted[robot] and float(rng.random()) < settings.reversal_probability:
                turning.append(robot)
        return np.array(turning, dtype=np.intp)

    def pick(self, robots: Indices) -> None:
        """Keep some robots, as ``arrays.pick`` does."""
        pick(self, ("_next",), robots)

"""Clocks of a team that are not quite right, drawn by the seed of a run."""

from __future__ import annotations

import numpy as np

from robot_agent.patrol.common_clock import CommonClock

_STREAM = 21  # apart from the other draws of a seed


def wrong_clocks(robots: int, seed: int, error: float, gain: float) -> list[CommonClock]:
    """Return the clock of each robot: off by up to ``error`` s at the start, uniformly, and gaining
    or losing up to ``gain`` s a day that its robot does not know of.
    """
    rng = np.random.default_rng((seed, _STREAM))
    offs, gains = rng.uniform(-error, error, robots), rng.uniform(-gain, gain, robots)
    # A drift that is believed and is not so has the same effect as one that is not believed.
    return [CommonClock(off, -own) for off, own in zip(offs.tolist(), gains.tolist(), strict=True)]

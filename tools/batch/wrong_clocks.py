"""Clocks of a team that are not quite right, drawn by the seed of a run."""

from __future__ import annotations

import numpy as np

from robot_agent.patrol.common_clock import DAY_S, CommonClock

_STREAM = 21  # apart from the other draws of a seed


def wrong_clocks(
    robots: int, seed: int, error: float, gain: float, *, drift_known: bool = False
) -> list[CommonClock]:
    """Return the clock of each robot: off by up to ``error`` s at the start, uniformly, and gaining
    or losing up to ``gain`` s a day.

    drift_known: ``patrol.clock_drift`` of each robot says what its clock gains; else it says 0.
    """
    rng = np.random.default_rng((seed, _STREAM))
    offs, gains = rng.uniform(-error, error, robots), rng.uniform(-gain, gain, robots)
    return [
        _by_right_time(off, own, own if drift_known else 0.0)
        for off, own in zip(offs.tolist(), gains.tolist(), strict=True)
    ]


def _by_right_time(off: float, gain: float, drift: float) -> CommonClock:
    """Return the common time that a robot believes in, by the right time of a batch.

    Its clock is off by so many s and gains ``gain`` s a day; its ``patrol.clock_drift`` is
    ``drift``.
    """
    own_time = 1.0 + gain / DAY_S  # s of its clock in one right second
    rate = own_time * CommonClock(0.0, drift).at(1.0)
    return CommonClock(off, (1.0 - rate) * DAY_S)

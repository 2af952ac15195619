"""What a patrol can reach at best against an intruder at one place.

With every place visited as evenly as may be, one in L / (N v), an intruder who strikes at a random
moment is seen with probability min(1, dwell N v / L); no patrol does better at all places. Against
one who knows where all robots are and how they decide, Agmon, Kaminka and Kraus ("Multi-robot
adversarial patrolling: facing a full-knowledge opponent", 2011) let evenly spaced robots turn all
together, at random, with the probability that makes the least probability of detection largest.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from maps.border import Border
from tools.metrics.intruder_exposure import DWELL_S

SEGMENT_M = 1.0
"""Length of a step of Agmon's robots along the border, m."""
TURN_STEPS = 2
"""Steps that a turn takes."""
_PROBABILITIES = np.linspace(0.02, 1.0, 50)  # of going on, at each step


def bound_figures(border: Border, robots: int, speed: float) -> dict[str, Any]:
    """Return ``intruder_bound`` of ``bench --json``, by dwell time; speed: of the patrol, m/s.

    turning_together: of a closed border; None on an open one.
    """
    length = border.length
    return {
        "intruder_bound": {
            "random": {f"{d:g}": random_bound(length, robots, speed, d) for d in DWELL_S},
            "turning_together": {
                f"{d:g}": turning_together(length, robots, speed, d) if border.closed else None
                for d in DWELL_S
            },
        }
    }


def random_bound(length: float, robots: int, speed: float, dwell: float) -> float:
    """Return what no patrol exceeds at its weakest place against a random moment.

    length: of the border, m. speed: m/s. dwell: s.
    """
    return min(1.0, dwell * robots * speed / length)


@cache  # the same for all runs of a study
def turning_together(length: float, robots: int, speed: float, dwell: float) -> float:
    """Return the best least probability of detection of robots that turn together, closed border.

    Against an intruder who knows everything but the coming turns; arguments as ``random_bound``.
    """
    between = round(length / robots / SEGMENT_M)
    steps = int(dwell * speed / SEGMENT_M)
    return max(_least_seen(between, steps, float(p)) for p in _PROBABILITIES)


def _least_seen(between: int, steps: int, go_on: float) -> float:
    """Return the least probability, over the segments, that a robot comes within some steps.

    Evenly spaced robots that turn together are one robot on a circle of ``between`` segments.
    Chains (segments, places, ways, steps still to turn) of all segments are followed at once.
    """
    chain = np.zeros((between, between, 2, TURN_STEPS))
    chain[1:, 0, 0, 0] = 1.0  # segment 0 has the robot
    seen = np.zeros(between)
    seen[0] = 1.0
    own = np.arange(between)
    for _ in range(steps):
        chain = _step(chain, go_on)
        seen += chain[own, own].sum(axis=(1, 2))
        chain[own, own] = 0.0
    return float(seen.min())


def _step(chain: NDArray[np.float64], go_on: float) -> NDArray[np.float64]:
    """Return the chains after one step: each robot goes on, begins a turn or turns on."""
    after = np.zeros_like(chain)
    after[..., :-1] = chain[..., 1:]
    free = chain[..., 0]
    after[:, :, 0, 0] += go_on * np.roll(free[:, :, 0], 1, axis=1)
    after[:, :, 1, 0] += go_on * np.roll(free[:, :, 1], -1, axis=1)
    after[..., -1] += (1.0 - go_on) * free[:, :, ::-1]
    return after

"""Heading loops and unpinning of many robots equal those of each, pins at the heading included."""

import numpy as np
import pytest

from robot_agent.motion.heading_loop import HeadingLoop
from robot_agent.motion.unpinning import UnpinningManoeuvre
from tools.batch.heading_loops import HeadingLoops, Unpinnings

ROBOTS, STEPS, DT = 20, 600, 0.125  # s: a time is the sum of its steps, to the last bit


def test_many_robots_have_the_commands_of_each():
    """Headings are kept, turned away from, and pinned, each for seconds at random."""
    rng = np.random.default_rng(1)
    loops, pins = HeadingLoops(ROBOTS), Unpinnings(ROBOTS)
    each = [(HeadingLoop(), UnpinningManoeuvre()) for _ in range(ROBOTS)]
    for loop, _ in each:
        loop.command(-DT, (0.0, 0.0), 0.0)  # from when the first step counts
    theta, pinned, edged_at_heading = np.zeros(ROBOTS), np.zeros(ROBOTS, dtype=bool), 0
    for step in range(STEPS):
        t = DT * step
        theta = np.where(rng.random(ROBOTS) < 0.05, rng.uniform(-3.0, 3.0, ROBOTS), theta)
        theta = np.where(rng.random(ROBOTS) < 0.05, rng.uniform(-0.2, 0.2, ROBOTS), theta)
        pinned ^= rng.random(ROBOTS) < 0.03
        curvature = rng.uniform(-0.5, 0.5, ROBOTS)
        velocity = np.full(ROBOTS, 0.35), np.zeros(ROBOTS)
        over = pins.step(t, loops, pinned)
        edged_at_heading += int((over[1] & loops.aligned).sum())
        v, w = loops.command(DT, velocity, theta, curvature, over)
        for k, (loop, unpinning) in enumerate(each):
            override = unpinning.step(t, loop.turn, pinned=bool(pinned[k]))
            assert (override.turn_side, override.edges) == (over[0][k], over[1][k])
            args = t, (0.35, 0.0), float(theta[k]), float(curvature[k]), override
            assert loop.command(*args) == pytest.approx((v[k], w[k]), abs=1e-9)
    assert edged_at_heading > 100

"""``HeadingLoop`` and ``UnpinningManoeuvre`` for many robots at once."""

from __future__ import annotations

import math

import numpy as np

from robot_agent.motion import unpinning
from robot_agent.motion.heading_loop import (
    GAIN,
    MAX_ACCELERATION,
    MAX_TURN_ACCELERATION,
    MAX_TURN_RATE,
    RESUME_ANGLE,
    ROLLING_SPEED,
    STANDSTILL_SPEED,
    TURN_ANGLE,
    TURN_BRAKING,
)
from tools.batch.angles import wrapped
from tools.batch.arrays import Codes, Flags, Indices, Reals, pick


class HeadingLoops:
    """Controls (v, w) of each robot by a velocity; keeps the last commands and turns."""

    def __init__(self, n: int) -> None:
        self.v = np.zeros(n)
        self.w = np.zeros(n)
        self.side = np.zeros(n, dtype=np.int8)  # of a turn in place: +1 left, -1 right
        self.aligned = np.zeros(n, dtype=np.bool_)

    def command(
        self,
        dt: float,
        velocity: tuple[Reals, Reals],
        theta: Reals,
        curvature: Reals,
        pins: tuple[Codes, Flags],
    ) -> tuple[Reals, Reals]:
        """Return (v, w), each (n,), m/s and rad/s, dt s after the last command.

        velocity, theta, curvature: as ``HeadingLoop.command`` takes them. pins: the side to turn
        to, 0 for the present one, and whether the robot edges straight ahead.
        """
        turn_to, edges = pins
        self.side = np.where(turn_to != 0, turn_to, self.side)
        v, w = self._targets(*velocity, theta, curvature)
        if edges.any():
            v[edges], w[edges] = unpinning.EDGING_SPEED, 0.0
        change, turn = MAX_ACCELERATION * dt, MAX_TURN_ACCELERATION * dt
        w = np.minimum(np.maximum(w, -MAX_TURN_RATE), MAX_TURN_RATE)
        self.v = self.v + np.minimum(np.maximum(v - self.v, -change), change)
        self.w = self.w + np.minimum(np.maximum(w - self.w, -turn), turn)
        return self.v, self.w

    def pick(self, robots: Indices) -> None:
        """Keep some robots, as ``arrays.pick`` does."""
        pick(self, ("v", "w", "side", "aligned"), robots)

    def _targets(self, vx: Reals, vy: Reals, theta: Reals, curvature: Reals) -> tuple[Reals, Reals]:
        speed = np.hypot(vx, vy)
        error = wrapped(np.arctan2(vy, vx) - theta)
        size = np.abs(error)
        stands = speed < STANDSTILL_SPEED
        # 1. The side to turn to in place.
        self.aligned = (size < RESUME_ANGLE) & ~stands
        begins = (self.side == 0) & (size > TURN_ANGLE)
        self.side = np.where(begins, np.where(error > 0.0, 1, -1), self.side).astype(np.int8)
        self.side[self.aligned | stands] = 0
        # 2. Drive on, along the path's arc.
        v = speed * np.maximum(np.cos(error), 0.0)
        w = _turn_rates(error) + self.v * curvature
        # 3. Or brake along it, then turn in place.
        some = (self.side != 0).nonzero()[0]
        if some.size:
            v[some] = 0.0
            rolling, off, side = self.v[some], error[some], self.side[some]
            back_along = np.where(np.abs(off) > math.pi / 2.0, -1.0, 1.0)
            braking = back_along * rolling * curvature[some]
            on_side = np.where(off * side >= 0.0, off, off + side * math.tau)
            w[some] = np.where(rolling > ROLLING_SPEED, braking, _turn_rates(on_side))
        v[stands] = w[stands] = 0.0
        return v, w


class Unpinnings:
    """State of each robot's manoeuvre out of a place where obstacles pin it."""

    def __init__(self, n: int) -> None:
        self._since = np.full(n, math.nan)
        self._pins = np.zeros(n, dtype=np.int8)
        self._edges_until = np.full(n, math.nan)
        self._edges_at_heading = np.zeros(n, dtype=np.bool_)

    def step(self, t: float, loops: HeadingLoops, pinned: Flags) -> tuple[Codes, Flags]:
        """Return the sides to turn to, and whether to edge ahead, as ``UnpinningManoeuvre``."""
        self._pins[loops.aligned] = 0
        n = len(pinned)
        side = np.zeros(n, dtype=np.int8)
        # nan, for none, compares as False.
        ends = (t >= self._edges_until) | (self._edges_at_heading & ~loops.aligned)
        if ends.any():
            self._edges_until[ends] = math.nan
            self._edges_at_heading[ends] = False
            side = np.where(ends & pinned, -loops.side, side)
        at_heading = loops.aligned & np.isnan(self._edges_until)
        counts = pinned & ((loops.w != 0.0) | at_heading)
        self._since[~counts] = math.nan
        for robot in counts.nonzero()[0].tolist():
            side[robot] = self._next_side(robot, t, loops) or side[robot]
        return side, ~np.isnan(self._edges_until)

    def pick(self, robots: Indices) -> None:
        """Keep some robots, as ``arrays.pick`` does."""
        pick(self, ("_since", "_pins", "_edges_until", "_edges_at_heading"), robots)

    def _next_side(self, robot: int, t: float, loops: HeadingLoops) -> int:
        if math.isnan(self._since[robot]):
            self._since[robot] = t
            return 0
        if t - self._since[robot] < unpinning.TIMEOUT:
            return 0
        self._since[robot] = math.nan
        self._pins[robot] += 1
        if not loops.aligned[robot] and self._pins[robot] < unpinning.PINS_BEFORE_EDGING:
            return -1 if loops.w[robot] > 0.0 else 1
        self._pins[robot] = 0
        self._edges_until[robot] = t + unpinning.EDGING_TIME
        self._edges_at_heading[robot] = loops.aligned[robot]
        return 0


def _turn_rates(error: Reals) -> Reals:
    """Return k e, rad/s, limited to what can be braked before the errors, rad, are zero."""
    size = np.abs(error)
    rate = np.minimum(GAIN * size, np.sqrt(2.0 * TURN_BRAKING * size))
    return np.asarray(np.copysign(np.minimum(rate, MAX_TURN_RATE), error))

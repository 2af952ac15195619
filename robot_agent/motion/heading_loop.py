"""Heading loop: from a velocity in the map to (v, w) of a differential drive.

Not in the paper; the usual loop under a null-space velocity. With the heading error
e = angle(velocity) - theta: if e is large the robot brakes and turns in place, to one side
throughout, as it never drives backwards. Otherwise v = |velocity| cos e and w = k e plus the turn
rate of the path itself.
"""

from __future__ import annotations

import math

from maps.pose import wrap_angle
from robot_agent.motion.unpinning import EDGING_SPEED, NO_UNPINNING, Turn, Unpinning

GAIN = 4.0  # 1/s, k
TURN_ANGLE = math.radians(60.0)  # rad of error beyond which to turn in place
RESUME_ANGLE = math.radians(15.0)  # rad of error below which to drive on
ROLLING_SPEED = 0.05  # m/s; above it the robot brakes before it turns in place
STANDSTILL_SPEED = 0.005  # m/s; a slower velocity means stand still
MAX_TURN_RATE = 1.2  # rad/s
MAX_ACCELERATION = 0.3  # m/s2, up and down
MAX_TURN_ACCELERATION = 2.0  # rad/s2
TURN_BRAKING = 1.0  # rad/s2 assumed in the approach to a heading; below the limit


class HeadingLoop:
    """Controls (v, w) by a velocity vector; keeps the last command and the side of a turn."""

    def __init__(self) -> None:
        self._t: float | None = None
        self._v = 0.0
        self._w = 0.0
        self._turn_side = 0  # +1 left, -1 right while turning in place, else 0
        self._aligned = False  # in the last step

    @property
    def turn(self) -> Turn:
        """The turn of the last command."""
        return Turn(self._w, self._turn_side, self._aligned)

    def command(
        self,
        t: float,
        velocity: tuple[float, float],
        theta: float,
        curvature: float = 0.0,
        unpinning: Unpinning = NO_UNPINNING,
    ) -> tuple[float, float]:
        """Return (v, w), m/s and rad/s, at t; call once per control step.

        velocity: target, m/s in the map frame; theta: heading in the map, rad; curvature: of the
        path ahead in the direction of velocity, 1/m, + left. unpinning: the side to turn to, or
        straight ahead, while obstacles pin the robot.
        """
        self._turn_side = unpinning.turn_side or self._turn_side
        v, w = self._target(velocity, theta, curvature)
        if unpinning.edges:
            v, w = EDGING_SPEED, 0.0
        dt = 0.0 if self._t is None else max(t - self._t, 0.0)
        self._t = t
        self._ramp(v, w, dt)
        return self._v, self._w

    def _target(
        self, velocity: tuple[float, float], theta: float, curvature: float
    ) -> tuple[float, float]:
        speed = math.hypot(*velocity)
        if speed < STANDSTILL_SPEED:
            self._turn_side, self._aligned = 0, False
            return 0.0, 0.0
        error = wrap_angle(math.atan2(velocity[1], velocity[0]) - theta)
        self._choose_turn_side(error)
        if not self._turn_side:
            v = speed * max(math.cos(error), 0.0)
            return v, self._turn_rate(error) + self._v * curvature
        if self._v > ROLLING_SPEED:
            # Turning while rolling would carry the robot off its path: brake along it first.
            back_along = -1.0 if abs(error) > math.pi / 2.0 else 1.0
            return 0.0, back_along * self._v * curvature
        return 0.0, self._turn_rate(_on_side(error, self._turn_side))

    def _choose_turn_side(self, error: float) -> None:
        """Start a turn in place beyond one angle, end it below another, to one side throughout."""
        if abs(error) < RESUME_ANGLE:
            self._turn_side, self._aligned = 0, True
            return
        self._aligned = False
        if self._turn_side == 0 and abs(error) > TURN_ANGLE:
            self._turn_side = 1 if error > 0.0 else -1

    def _turn_rate(self, error: float) -> float:
        """Return k e, rad/s, limited to what can be braked before the error, rad, is zero."""
        braking = math.sqrt(2.0 * TURN_BRAKING * abs(error))
        rate = min(GAIN * abs(error), braking, MAX_TURN_RATE)
        return math.copysign(rate, error)

    def _ramp(self, v: float, w: float, dt: float) -> None:
        change = MAX_ACCELERATION * dt
        turn = MAX_TURN_ACCELERATION * dt
        w = _within(w, -MAX_TURN_RATE, MAX_TURN_RATE)
        self._v += _within(v - self._v, -change, change)
        self._w += _within(w - self._w, -turn, turn)


def _within(value: float, low: float, high: float) -> float:
    """Return a value clamped to low..high; faster than min and max."""
    return low if value < low else high if value > high else value


def _on_side(error: float, side: int) -> float:
    """Return the same error, rad, as the angle to turn on the given side (+1 left, -1 right)."""
    return error if error * side >= 0.0 else error + side * math.tau

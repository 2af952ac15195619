"""From a velocity in the map to forward speed and turning rate of a differential drive.

Not in the paper; the usual heading loop under a null-space velocity. With the heading error
e = angle(velocity) - theta: far off, the robot brakes, then turns on the spot, since it never
backs up; one side throughout, but the other when an obstacle there pins it; pinned on both, it
edges ahead to where there is more room. Otherwise v = |velocity| cos e and w = k e plus the
turning rate of the path itself.
"""

from __future__ import annotations

import math
from typing import Annotated

import msgspec

from maps.pose import wrap_angle

Positive = Annotated[float, msgspec.Meta(gt=0.0)]
NotNegative = Annotated[float, msgspec.Meta(ge=0.0)]
Angle = Annotated[float, msgspec.Meta(gt=0.0, lt=math.pi)]


_PINS_BEFORE_EDGING = 3  # one side, the other, and the first again


class HeadingSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Gains and limits of the heading loop."""

    gain: Positive = 4.0  # 1/s, k
    turn_angle: Angle = math.radians(60.0)  # rad of error beyond which to turn on the spot
    resume_angle: Angle = math.radians(15.0)  # rad of error below which to drive on
    rolling_speed: NotNegative = 0.05  # m/s; faster the robot brakes before it turns on the spot
    standstill_speed: NotNegative = 0.005  # m/s; a slower velocity means stand still
    max_turn_rate: Positive = 1.2  # rad/s
    max_acceleration: Positive = 0.3  # m/s2
    max_deceleration: Positive = 0.3  # m/s2
    max_turn_acceleration: Positive = 2.0  # rad/s2
    pinned_patience: NotNegative = 1.0  # s that an obstacle pins it until it turns the other way
    edging_speed: NotNegative = 0.1  # m/s ahead, out of a place where it cannot turn either way
    edging_time: NotNegative = 1.5  # s of that
    turn_braking: Positive = 1.0  # rad/s2 the approach to a heading counts on; less than the limit

    def __post_init__(self) -> None:
        """Refuse a hysteresis upside down."""
        if self.resume_angle > self.turn_angle:
            raise ValueError(
                f"resume_angle {self.resume_angle} rad must not exceed "
                f"turn_angle {self.turn_angle} rad"
            )


class HeadingLoop:
    """Steers by a velocity vector; remembers its last command and the side of a turn."""

    def __init__(self, settings: HeadingSettings) -> None:
        self._settings = settings
        self._t: float | None = None
        self._v = 0.0
        self._w = 0.0
        self._turn_side = 0  # +1 left, -1 right while turning on the spot, else 0
        self._pinned_since: float | None = None
        self._pins = 0  # of the present turn
        self._edges_until: float | None = None  # s, while edging ahead

    def command(
        self,
        t: float,
        velocity: tuple[float, float],
        theta: float,
        curvature: float = 0.0,
        *,
        pinned: bool = False,
    ) -> tuple[float, float]:
        """Return (v, w), m/s and rad/s, at t, s.

        velocity: wanted, m/s in the map frame; theta: heading in the map, rad; curvature: of the
        path ahead in the sense of velocity, 1/m, + turning left. pinned: an obstacle let it neither
        drive nor turn by its last command.
        """
        self._turn_from_obstacle(t, pinned=pinned)
        v, w = self._target(velocity, theta, curvature)
        if self._edges_until is not None:
            v, w = self._settings.edging_speed, 0.0
        dt = 0.0 if self._t is None else max(t - self._t, 0.0)
        self._t = t
        self._ramp(v, w, dt)
        return self._v, self._w

    def _turn_from_obstacle(self, t: float, *, pinned: bool) -> None:
        """Turn the other way once pinned for too long while turning; back at the first, edge out.

        The first side was the shorter way round, so edging ahead there leads less astray; but when
        no way is there, as that side is towards a wall, the next attempt is from the other.
        """
        if self._edges_until is not None and t >= self._edges_until:
            self._edges_until = None
            if pinned:
                self._turn_side = -self._turn_side
        if not pinned or self._w == 0.0:
            self._pinned_since = None
        elif self._pinned_since is None:
            self._pinned_since = t
        elif t - self._pinned_since >= self._settings.pinned_patience:
            self._pinned_since = None
            self._pins += 1
            if self._pins < _PINS_BEFORE_EDGING:
                self._turn_side = -1 if self._w > 0.0 else 1
            else:
                self._pins = 0
                self._edges_until = t + self._settings.edging_time

    def _target(
        self, velocity: tuple[float, float], theta: float, curvature: float
    ) -> tuple[float, float]:
        speed = math.hypot(*velocity)
        if speed < self._settings.standstill_speed:
            self._turn_side = 0
            return 0.0, 0.0
        error = wrap_angle(math.atan2(velocity[1], velocity[0]) - theta)
        self._choose_turn_side(error)
        if not self._turn_side:
            v = speed * max(math.cos(error), 0.0)
            return v, self._turn_rate(error) + self._v * curvature
        if self._v > self._settings.rolling_speed:
            # Turning while rolling would carry the robot off its path: brake along it first.
            back_along = -1.0 if abs(error) > math.pi / 2.0 else 1.0
            return 0.0, back_along * self._v * curvature
        return 0.0, self._turn_rate(_on_side(error, self._turn_side))

    def _choose_turn_side(self, error: float) -> None:
        """Begin to turn on the spot beyond one angle, end below another, one side throughout."""
        if abs(error) < self._settings.resume_angle:
            self._turn_side = self._pins = 0
        elif self._turn_side == 0 and abs(error) > self._settings.turn_angle:
            self._turn_side = 1 if error > 0.0 else -1

    def _turn_rate(self, error: float) -> float:
        """k e, but no faster than can still be braked before the error is gone."""
        settings = self._settings
        braking = math.sqrt(2.0 * settings.turn_braking * abs(error))
        rate = min(settings.gain * abs(error), braking, settings.max_turn_rate)
        return math.copysign(rate, error)

    def _ramp(self, v: float, w: float, dt: float) -> None:
        settings = self._settings
        faster, slower = settings.max_acceleration * dt, settings.max_deceleration * dt
        turn = settings.max_turn_acceleration * dt
        w = _within(w, -settings.max_turn_rate, settings.max_turn_rate)
        self._v += _within(v - self._v, -slower, faster)
        self._w += _within(w - self._w, -turn, turn)


def _within(value: float, low: float, high: float) -> float:
    """Return a value cut to what lies between two others; faster than min and max."""
    return low if value < low else high if value > high else value


def _on_side(error: float, side: int) -> float:
    """Return the same error, rad, turned away by going round the given side."""
    return error if error * side >= 0.0 else error + side * math.tau

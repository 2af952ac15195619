"""The emulated controller's motion servers: setpoints, trapezoidal profiles, wheel speeds.

Source: Pioneer 2 Operations Manual, motion commands. Speeds here are of the robot's centre,
v in m/s forward and w in rad/s counter-clockwise.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from drivers.p2os.command_numbers import CommandNumber
from drivers.p2os.commands import Command
from drivers.p2os.emulator.make import BaseMake

E_STOPS = frozenset({CommandNumber.E_STOP, CommandNumber.QSTOP})
VELOCITIES = frozenset(
    {CommandNumber.VEL, CommandNumber.RVEL, CommandNumber.ROTATE, CommandNumber.VEL2}
)
"""Commands that end an emergency stop."""
ARRIVED = 0.0005  # m short of a MOVE's end
ARRIVED_SPEED = 0.01  # m/s


@dataclass(slots=True)
class MotionLimits:
    """Limits set by SETV, SETRV, SETA and SETRA; the defaults are those of the FLASH."""

    speed: float  # m/s
    turn_rate: float  # rad/s
    acceleration: float = 0.3  # m/s^2
    deceleration: float = 0.3  # m/s^2
    turn_acceleration: float = math.radians(100.0)  # rad/s^2
    turn_deceleration: float = math.radians(100.0)  # rad/s^2


def limits_of(model: BaseMake) -> MotionLimits:
    """Return the limits a controller starts with."""
    return MotionLimits(speed=model.top_speed, turn_rate=model.top_turn_rate)


def ramp(speed: float, goal: float, up: float, down: float, dt: float) -> tuple[float, float]:
    """Follow a trapezoidal profile for ``dt`` s; return (new speed, distance covered).

    ``up`` is the acceleration away from zero, ``down`` the one towards it, both positive.
    """
    distance = 0.0
    if goal * speed < 0.0 or abs(goal) < abs(speed):
        slowest = goal if goal * speed > 0.0 else 0.0
        speed, distance, dt = approach(speed, slowest, down, dt)
    speed, more, dt = approach(speed, goal, up, dt)
    return speed, distance + more + speed * dt


def approach(speed: float, goal: float, rate: float, dt: float) -> tuple[float, float, float]:
    """Change speed at a constant rate towards a goal for at most ``dt`` s.

    Return (new speed, distance covered, time left).
    """
    needed = abs(goal - speed) / rate
    if needed <= dt + 1e-9:
        return goal, 0.5 * (speed + goal) * needed, max(0.0, dt - needed)
    reached = speed + math.copysign(rate * dt, goal - speed)
    return reached, 0.5 * (speed + reached) * dt, 0.0


def stopping_speed(remaining: float, deceleration: float, limit: float, dt: float) -> float:
    """Return the top speed for the next ``dt`` s that leaves enough of ``remaining`` to stop."""
    loss = deceleration * dt
    fastest = math.sqrt(loss * loss + 2.0 * deceleration * abs(remaining)) - loss
    return math.copysign(min(limit, fastest), remaining)


class MotionController:
    """Converts motion commands to wheel speeds over time."""

    def __init__(self, model: BaseMake) -> None:
        self.limits = limits_of(model)
        self.v = 0.0
        self.w = 0.0
        self._model = model
        self._speed = 0.0
        self._turn_rate = 0.0
        self._travel: float | None = None  # m left of a MOVE
        self._heading: float | None = None  # rad in odom, of HEAD or DHEAD
        self._wheels_independent = False
        self._emergency = False

    @property
    def at_rest(self) -> bool:
        """Whether speeds and setpoints are zero."""
        goals = (self.v, self.w, self._speed, self._turn_rate)
        return not any(goals) and self._travel is None and self._heading is None

    def heading_setpoint(self, heading: float) -> float:
        """Return the heading setpoint, rad; ``heading`` itself if there is none."""
        return heading if self._heading is None else self._heading

    def drop_setpoints(self) -> None:
        """Set all setpoints to standstill; the ramps still apply."""
        self._speed = self._turn_rate = 0.0
        self._travel = self._heading = None

    def halt(self) -> None:
        """Set the speeds to zero at once, as when the motors lose power; setpoints stay."""
        self.v = self.w = 0.0

    def set_limit(self, command: Command) -> None:
        """Execute SETV, SETRV, SETA or SETRA; zero leaves the limit unchanged."""
        limits, value = self.limits, command.integer
        if value == 0:
            return
        size = abs(value)
        if command.number == CommandNumber.SETV:
            limits.speed = min(0.001 * size, self._model.top_speed)
        elif command.number == CommandNumber.SETRV:
            limits.turn_rate = min(math.radians(size), self._model.top_turn_rate)
        elif command.number == CommandNumber.SETA:
            if value > 0:
                limits.acceleration = 0.001 * size
            else:
                limits.deceleration = 0.001 * size
        elif command.number == CommandNumber.SETRA:
            if value > 0:
                limits.turn_acceleration = math.radians(size)
            else:
                limits.turn_deceleration = math.radians(size)

    def obey(self, command: Command, heading: float) -> None:
        """Execute a motion command; ``heading`` is the odometer's, rad."""
        number = command.number
        if number == CommandNumber.STOP or number in E_STOPS:
            self.drop_setpoints()
            if number in E_STOPS:
                self.halt()
                self._emergency = True
        elif number in VELOCITIES or not self._emergency:
            self._emergency = False
            self._set_point(number, command, heading)

    def _set_point(self, number: int, command: Command, heading: float) -> None:
        if number == CommandNumber.VEL2:
            self._set_wheels(*command.two_bytes)
            return
        if self._wheels_independent:
            self._wheels_independent = False
            self.drop_setpoints()
        if number in (CommandNumber.VEL, CommandNumber.MOVE):
            self._set_translation(number, 0.001 * command.integer)
        else:
            self._set_rotation(number, math.radians(command.integer), heading)

    def _set_translation(self, number: int, value: float) -> None:
        if number == CommandNumber.VEL:
            self._speed, self._travel = self._clamp_speed(value), None
        else:
            self._speed, self._travel = 0.0, value

    def _set_rotation(self, number: int, value: float, heading: float) -> None:
        if number in (CommandNumber.RVEL, CommandNumber.ROTATE):
            self._turn_rate, self._heading = self._clamp_turn_rate(value), None
            return
        start = {
            CommandNumber.HEAD: 0.0,
            CommandNumber.DHEAD: heading,
            CommandNumber.DCHEAD: self.heading_setpoint(heading),
        }[CommandNumber(number)]
        self._turn_rate, self._heading = 0.0, start + value

    def run(
        self,
        dt: float,
        heading: float,
        *,
        halted: bool,
        forward: bool,
        backward: bool,
        braking: float = 1.0,
    ) -> tuple[float, float]:
        """Run ``dt`` s; return the wheels' motion as (distance m, rotation rad).

        ``heading`` is the odometer's, rad; ``halted`` stops by the ramps but keeps the setpoints;
        ``forward`` and ``backward``: whether the bumpers permit the direction. ``braking``: share
        of the deceleration that the motors reach.
        """
        speed, turn_rate = (0.0, 0.0) if halted else self._goals(dt, heading)
        if (speed > 0.0 and not forward) or (speed < 0.0 and not backward):
            speed = 0.0
        limits = self.limits
        self.v, distance = ramp(
            self.v, speed, limits.acceleration, limits.deceleration * braking, dt
        )
        self.w, rotation = ramp(
            self.w, turn_rate, limits.turn_acceleration, limits.turn_deceleration * braking, dt
        )
        if self._travel is not None:
            self._travel -= distance
            if abs(self._travel) < ARRIVED and abs(self.v) < ARRIVED_SPEED:
                self._travel = None
        return distance, rotation

    def _goals(self, dt: float, heading: float) -> tuple[float, float]:
        limits = self.limits
        speed, turn_rate = self._speed, self._turn_rate
        if self._travel is not None:
            speed = stopping_speed(self._travel, limits.deceleration, limits.speed, dt)
        if self._heading is not None:
            error = math.remainder(self._heading - heading, math.tau)
            turn_rate = stopping_speed(error, limits.turn_deceleration, limits.turn_rate, dt)
        return speed, turn_rate

    def _set_wheels(self, left: int, right: int) -> None:
        self.drop_setpoints()
        self._wheels_independent = True
        count = self._model.wheel_speed_count
        self._speed = self._clamp_speed(0.5 * count * (left + right))
        half_difference = 0.5 * count * (right - left)
        self._turn_rate = self._clamp_turn_rate(half_difference * self._model.turn)

    def _clamp_speed(self, speed: float) -> float:
        return max(-self.limits.speed, min(self.limits.speed, speed))

    def _clamp_turn_rate(self, turn_rate: float) -> float:
        return max(-self.limits.turn_rate, min(self.limits.turn_rate, turn_rate))

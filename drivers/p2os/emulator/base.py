"""The hardware of an emulated robot base: motors, wheels, contacts, battery, counters.

Source: Pioneer 2 Operations Manual, motion commands, watchdog, stall and bumpers.
"""

from __future__ import annotations

import math

from drivers.p2os.commands import Command
from drivers.p2os.emulator.battery import EmulatedBattery
from drivers.p2os.emulator.make import BaseMake
from drivers.p2os.emulator.motion_controller import MotionController

MOTION_CYCLE = 0.010  # s
FACTORY_WATCHDOG = 2.0  # s without a packet after which motion halts; in the FLASH
STALL_PAUSE = 0.1  # s without motor power after a stall
TICKS_PER_METRE = 128_000  # of a wheel's encoder


class EmulatedBase:
    """Converts setpoints to wheel motion, and wheel motion to the values a controller reports."""

    def __init__(self, model: BaseMake, watchdog: float = FACTORY_WATCHDOG) -> None:
        self.model = model
        self.watchdog = watchdog
        self.battery = EmulatedBattery(model.battery)
        self.controller = MotionController(model)
        self.motors_enabled = False
        self.stop_button_pressed = False
        self.session_open = False
        self.heard_at = -math.inf
        """Time of the client's last packet."""
        self.front_bumpers = self.rear_bumpers = 0
        self.bump_stall = 0
        self.e_stall = False
        """Whether a pressed stop button counts as a stall."""
        self.fault_flags = 0
        """Faults as the SIPs of ARCOS report them."""
        self.braking = 1.0
        """Share of the ordered deceleration that the motors reach."""
        self.x = self.y = self.theta = 0.0  # odometer: m, m, rad
        self._ticks = [0.0, 0.0]
        self._moved = (0.0, 0.0)  # wheel motion not yet fetched: m, rad
        self._t: float | None = None
        self._power_back = -math.inf
        self._blocked = False

    @property
    def velocity(self) -> tuple[float, float]:
        """Present speed of the wheels as (v m/s, w rad/s)."""
        return self.controller.v, self.controller.w

    @property
    def watchdog_expired(self) -> bool:
        """Whether motion is halted because the client sent no packet in time."""
        return self._t is not None and self._t - self.heard_at >= self.watchdog - 1e-9

    @property
    def motion_permitted(self) -> bool:
        """Whether setpoints can move the wheels now."""
        return self.session_open and self.motors_enabled and not self.watchdog_expired

    @property
    def stalled(self) -> bool:
        """Whether the wheels are blocked, by the world or by bumpers configured to stall."""
        powerless = self._t is not None and self._t < self._power_back
        bumped = self._front_blocked or self._rear_blocked
        return self._blocked or powerless or bumped or self.stopped_by_button

    @property
    def stopped_by_button(self) -> bool:
        """Whether a pressed stop button is reported as a stall."""
        return self.e_stall and self.stop_button_pressed

    @property
    def heading(self) -> float:
        """Heading by the encoders, rad: the odometer's and the motion not yet fetched."""
        return self.theta + self._moved[1]

    @property
    def ticks(self) -> tuple[int, int]:
        """Encoder counts of the left and the right wheel, signed 32 bits."""
        left, right = (round(ticks) for ticks in self._ticks)
        return _wrapped(left), _wrapped(right)

    def open_session(self) -> None:
        """Start at the origin, with the limits of the controller's FLASH."""
        self.session_open = True
        self.controller = MotionController(self.model)
        self.x = self.y = self.theta = 0.0

    def close_session(self) -> None:
        """Stand still without power, forget setpoints, limits and bumper settings."""
        self.session_open = self.motors_enabled = False
        self.controller = MotionController(self.model)
        self.bump_stall = 0

    def enable_motors(self, *, on: bool) -> None:
        """Switch the motors; a pressed stop button keeps them off."""
        self.motors_enabled = on and self.session_open and not self.stop_button_pressed
        if not self.motors_enabled:
            self.controller.drop_setpoints()
            self.controller.halt()

    def press_stop_button(self) -> None:
        """Cut the motors' power; it stays off until the button is released and ENABLE comes."""
        self.stop_button_pressed = True
        self.enable_motors(on=False)

    def obey_motion(self, command: Command) -> bool:
        """Execute a motion command; return False and do nothing while the motors are off."""
        if self.motors_enabled:
            self.controller.obey(command, self.heading)
        return self.motors_enabled

    def run_to(self, t: float) -> None:
        """Advance to ``t``, in cycles of the motion servers unless at rest."""
        if self._t is None:
            self._t = t
        while self._t < t - 1e-9:
            idle = self.controller.at_rest or not self.motors_enabled
            dt = t - self._t if idle else min(MOTION_CYCLE, t - self._t)
            distance = 0.0 if idle else self._run_cycle(self._t, dt)
            self.battery.drain(dt, distance)
            self._t = t if idle else self._t + dt

    def pop_motion(self) -> tuple[float, float]:
        """Return the wheels' motion since the last call as (distance m, rotation rad)."""
        moved, self._moved = self._moved, (0.0, 0.0)
        return moved

    def turn_odometer(self, distance: float, rotation: float) -> None:
        """Add encoder motion to the odometer: ``distance`` m along an arc of ``rotation`` rad."""
        middle = self.theta + 0.5 * rotation
        self.x += distance * math.cos(middle)
        self.y += distance * math.sin(middle)
        self.theta += rotation
        half_difference = rotation / self.model.turn
        self._ticks[0] += TICKS_PER_METRE * (distance - half_difference)
        self._ticks[1] += TICKS_PER_METRE * (distance + half_difference)

    def set_odometry(self, x: float, y: float, theta: float) -> None:
        """Set the odometer (m, m, rad)."""
        self.x, self.y, self.theta = x, y, theta

    def set_contact(self, *, stalled: bool, front_bumpers: int, rear_bumpers: int) -> None:
        """Set whether the wheels are blocked and which bumper segments are pressed (bit 0 =
        first). A stall cuts the motors' power for STALL_PAUSE."""
        self._blocked = stalled
        self.front_bumpers, self.rear_bumpers = front_bumpers, rear_bumpers
        v = self.controller.v
        bumped = (v > 0.0 and self._front_blocked) or (v < 0.0 and self._rear_blocked)
        if (stalled or bumped) and self._t is not None and self._t >= self._power_back:
            self._power_back = self._t + STALL_PAUSE
            self.controller.halt()

    def _run_cycle(self, t: float, dt: float) -> float:
        if t < self._power_back - 1e-9:
            self.controller.halt()
            return 0.0
        distance, rotation = self.controller.run(
            dt,
            self.heading,
            halted=self.watchdog_expired,
            forward=not self._front_blocked,
            backward=not self._rear_blocked,
            braking=self.braking,
        )
        self._moved = (self._moved[0] + distance, self._moved[1] + rotation)
        return distance

    @property
    def _front_blocked(self) -> bool:
        return bool(self.bump_stall & 1 and self.front_bumpers)

    @property
    def _rear_blocked(self) -> bool:
        return bool(self.bump_stall & 2 and self.rear_bumpers)


def _wrapped(ticks: int) -> int:
    return (ticks + (1 << 31)) % (1 << 32) - (1 << 31)

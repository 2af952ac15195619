"""The safety gate: the last stage of every command on its way to the base. It denies by default.

The gate knows nothing of intent. It permits motion only while all it depends on is known to be
well, and only as fast as the robot can still stop before the nearest obstacle its body would
sweep over. The limited mode, for teleoperation and for a robot that is lost, asks for no pose
but is slow. v never leaves larger than wished, nor w larger than wished or last let pass; the
robot is never backed: what is behind it only sonars hear.
"""

from __future__ import annotations

import math
from collections import Counter

import msgspec
import numpy as np
from numpy.typing import NDArray

from robot_agent.motion.battery_watch import BatteryWatch
from robot_agent.motion.gate_limits import GateLimits
from robot_agent.motion.gate_reason import DENIALS, GateReason
from robot_agent.motion.repeated_fault_latch import RepeatedFaultLatch
from robot_agent.motion.stopping import stoppable_rate, stopping_way
from robot_agent.motion.swept_footprint import SweptFootprint

_LONGEST_STEP = 0.3  # s between two commands that count for the acceleration


class GateInputs(msgspec.Struct, frozen=True):
    """What the gate depends on; None: never heard of."""

    base_time: float | None  # s, when the last base report was measured
    scan_time: float | None  # s, when the last laser scan was measured
    health: str | None  # of the localization: "localized", "unsure"; anything else denies
    motors_enabled: bool
    stop_button: bool  # pressed, or it has switched the motors off
    stalled: bool
    bumpers: int  # bit masks of front and rear, together
    battery: float  # V
    v: float  # m/s, as the base reports
    w: float  # rad/s
    obstacles: NDArray[np.float64]  # (n, 2) m in base_link: laser returns and sonar points
    overloaded: bool = False  # the agent lags behind what it is told
    limited: bool = False  # limited mode: no localization needed, but slow; all else as ever


class GateDecision(msgspec.Struct, frozen=True):
    """What may go to the base, m/s and rad/s, and the first reason why it is less than wished."""

    v: float
    w: float
    reason: GateReason


class SafetyGate:
    """Cuts commands; remembers its last for the limits of acceleration, and what must be latched.

    ``stops`` counts how often each denial, and obstacles that let nothing pass, began.
    """

    def __init__(self, settings: GateLimits) -> None:
        self._settings = settings
        self._body = SweptFootprint(settings)
        window = settings.strike_window
        self._bumps = RepeatedFaultLatch(settings.bumps, window)
        self._stalls = RepeatedFaultLatch(settings.stalls, window)
        self._battery = BatteryWatch(
            settings.battery_cutoff, settings.battery_resume, settings.battery_patience
        )
        self._held = False  # by the stop button
        self._t: float | None = None
        self._v = 0.0
        self._w = 0.0
        self._acceleration = 0.0  # m/s2, of the last step; not negative
        self._reason = GateReason.NONE
        self.stops: Counter[GateReason] = Counter()

    def permit(self, t: float, requested: tuple[float, float], inputs: GateInputs) -> GateDecision:
        """Return the permitted part of requested (v m/s, w rad/s) at t, s.

        The reasons, in order: whatever denies all motion, an obstacle, the limited mode, an
        unsure pose, the speed limits, the acceleration limits.
        """
        self._remember(t, inputs)
        denied = self._denial(t, requested, inputs)
        if denied is not None:
            self._t = None  # start again from standstill
            return self._decided(0.0, 0.0, denied)
        elapsed = 0.0 if self._t is None else min(max(t - self._t, 0.0), _LONGEST_STEP)
        self._t = t
        v, w, slowed = self._within_speed(*requested, inputs)
        ramped = self._ramped(v, w, elapsed)
        free = self._within_sight(*ramped, inputs)
        self._acceleration = max(free[0] - self._v, 0.0) / elapsed if elapsed > 0.0 else 0.0
        if free != ramped:
            return self._decided(*free, GateReason.OBSTACLE)
        if slowed is GateReason.NONE and ramped != (v, w):
            slowed = GateReason.ACCELERATION
        return self._decided(*free, slowed)

    def expire(
        self, t: float, base_time: float | None, scan_time: float | None
    ) -> GateDecision | None:
        """Between two reports: withdraw what was last let pass once what it rests on is too old.

        base_time, scan_time: as in the inputs. None while nothing moves, or it may go on.
        """
        if self._v == self._w == 0.0:
            return None
        settings = self._settings
        if not _is_fresh(t, base_time, settings.max_base_age):
            reason = GateReason.STALE_BASE
        elif not _is_fresh(t, scan_time, settings.scan_age):
            reason = GateReason.STALE_LASER
        else:
            return None
        self._t = None  # start again from standstill
        return self._decided(0.0, 0.0, reason)

    def _decided(self, v: float, w: float, reason: GateReason) -> GateDecision:
        """Note what leaves, and count it when it is a new stop."""
        self._v, self._w = v, w
        stops = reason in DENIALS or (reason is GateReason.OBSTACLE and v == w == 0.0)
        if stops and reason is not self._reason:
            self.stops[reason] += 1
        self._reason = reason
        return GateDecision(v, w, reason)

    # ---- all or nothing -----------------------------------------------------------------------

    def _remember(self, t: float, inputs: GateInputs) -> None:
        """Follow what one report alone does not tell; a freed stop button releases the latches.

        A person who has looked at the robot switches its motors off and on at the robot itself.
        """
        self._bumps.update(t, struck=inputs.bumpers != 0, held=inputs.stop_button)
        self._stalls.update(t, struck=inputs.stalled, held=inputs.stop_button)
        self._battery.update(t, inputs.battery)
        if self._held and not inputs.stop_button:
            self._bumps.release()
            self._stalls.release()
        self._held = inputs.stop_button

    def _denial(
        self, t: float, requested: tuple[float, float], inputs: GateInputs
    ) -> GateReason | None:
        """Return the first reason to deny all motion, if any."""
        return self._unknown(t, requested, inputs) or self._unwell(requested, inputs)

    def _unknown(
        self, t: float, requested: tuple[float, float], inputs: GateInputs
    ) -> GateReason | None:
        """Return the first reason why it is not known how the robot fares, if any."""
        settings = self._settings
        numbers = (t, *requested, inputs.v, inputs.w, inputs.battery)
        if not all(map(math.isfinite, numbers)):
            return GateReason.INVALID
        if not _is_fresh(t, inputs.base_time, settings.max_base_age):
            return GateReason.STALE_BASE
        if not _is_fresh(t, inputs.scan_time, settings.scan_age):
            return GateReason.STALE_LASER
        if not _all_finite(inputs.obstacles):
            return GateReason.INVALID
        if inputs.overloaded:
            return GateReason.OVERLOADED
        located = inputs.limited or inputs.health in ("localized", "unsure")
        return None if located else GateReason.NOT_LOCALIZED

    def _unwell(self, requested: tuple[float, float], inputs: GateInputs) -> GateReason | None:
        """Return the first known reason to deny all motion, if any."""
        settings = self._settings
        if self._bumps.latched:
            return GateReason.BUMPED_AGAIN
        if self._stalls.latched:
            return GateReason.STALLED_AGAIN
        if inputs.stop_button:
            return GateReason.STOP_BUTTON
        if self._battery.low:
            return GateReason.BATTERY_LOW
        if not inputs.motors_enabled:
            return GateReason.MOTORS_OFF
        if inputs.stalled:
            return GateReason.STALLED
        if inputs.bumpers:
            return GateReason.BUMPER
        if (
            abs(inputs.v) > settings.max_speed + settings.overspeed
            or abs(inputs.w) > settings.max_turn_rate + settings.overspeed
        ):
            return GateReason.OVERSPEED
        return None if requested[0] >= 0.0 else GateReason.BACKING

    # ---- limits -------------------------------------------------------------------------------

    def _within_speed(
        self, v: float, w: float, inputs: GateInputs
    ) -> tuple[float, float, GateReason]:
        """Slow down along the wished arc to the speed limits."""
        settings = self._settings
        limit, turn_limit, reason = (
            settings.max_speed,
            settings.max_turn_rate,
            GateReason.SPEED_LIMIT,
        )
        if inputs.health == "unsure" or inputs.limited:
            limit, reason = min(settings.unsure_speed, limit), GateReason.UNSURE
        if inputs.limited:
            turn_limit, reason = min(settings.limited_turn_rate, turn_limit), GateReason.LIMITED
        share = min(
            limit / v if v > limit else 1.0,
            turn_limit / abs(w) if abs(w) > turn_limit else 1.0,
        )
        if share == 1.0:
            return v, w, GateReason.NONE
        return v * share, w * share, reason

    def _ramped(self, v: float, w: float, elapsed: float) -> tuple[float, float]:
        """Limit the change since the last command let pass; driving slower is never delayed.

        Turning is changed only as fast as the base can follow, both ways, so that the arc looked
        along is the arc driven.
        """
        settings = self._settings
        turn = settings.max_turn_acceleration * elapsed
        acceleration = min(
            settings.max_acceleration, self._acceleration + settings.max_jerk * elapsed
        )
        return (
            min(v, self._v + acceleration * elapsed),
            min(max(w, self._w - turn), self._w + turn),
        )

    def _within_sight(self, v: float, w: float, inputs: GateInputs) -> tuple[float, float]:
        """Slow down along the arc to what can be stopped before an obstacle; else only turn.

        The base may still move faster than it was told to: what it does now is what has to stop.
        """
        settings = self._settings
        delay = settings.reaction_delay
        rolling = max(v, inputs.v)
        spin = max(abs(w), abs(inputs.w)) if w * inputs.w > 0.0 else abs(w)
        turn = stopping_way(spin, settings.turn_braking, delay)
        if rolling > settings.creep_speed:
            stop = stopping_way(rolling, settings.braking, delay)
            arc = math.copysign(max(stop * abs(w) / rolling, turn), w)
            free = stop * self._body.free_share(stop, arc, inputs.obstacles)
            if free == stop:
                return v, w
            if stopping_way(inputs.v, settings.braking, 0.0) > free:
                return 0.0, 0.0  # this arc cannot be entered any more
            slow = min(v, stoppable_rate(free, settings.braking, delay))
            if slow > settings.creep_speed:
                return slow, w * slow / rolling
        free = turn * self._body.free_share(0.0, math.copysign(turn, w), inputs.obstacles)
        if free == turn:
            return 0.0, w
        slow = min(abs(w), stoppable_rate(free, settings.turn_braking, delay))
        return 0.0, math.copysign(slow, w)


def _all_finite(points: NDArray[np.float64]) -> bool:
    return not len(points) or bool(np.isfinite(points).all())


def _is_fresh(t: float, measured: float | None, max_age: float) -> bool:
    return measured is not None and 0.0 <= t - measured < max_age

"""The safety gate: the last stage of every velocity command before the base. It denies by default.

The gate is independent of the command's purpose. It permits motion only while all its inputs are
fresh and valid, driving only where a sensor's field of view covers the way, and only as fast as the
robot can stop before the nearest obstacle in the area its footprint would sweep. The limited mode,
for teleoperation and for a lost robot, needs no pose but is slow. The permitted v never exceeds the
requested one, nor w the larger of requested and last permitted; the robot never drives backwards,
as only sonars cover the area behind it.
"""

from __future__ import annotations

import math
from collections import Counter

import msgspec
import numpy as np
from numpy.typing import NDArray

from robot_agent.motion.battery_watch import BatteryWatch
from robot_agent.motion.field_of_view import FieldOfView, are_covered
from robot_agent.motion.gate_limits import GateLimits
from robot_agent.motion.gate_reason import DENIALS, STANDING, GateReason
from robot_agent.motion.repeated_fault_latch import RepeatedFaultLatch
from robot_agent.motion.stopping import stoppable_rate, stopping_way
from robot_agent.motion.swept_footprint import SweptFootprint

MORE_ROOM = 0.015  # m, ours: as much as noise shifts the nearest point of a surface
TURNED_AWAY = 0.2
"""rad from where an obstacle stopped a turn, ours: back there one look decides, not one of many."""
BEGUN = 0.05
"""rad that a turn has gone before a stop of it counts, ours: at once, it may be a false echo."""
_LONGEST_STEP = 0.3  # s; longer intervals between commands count as this for the acceleration


class GateInputs(msgspec.Struct, frozen=True):
    """Inputs of the gate; None: no valid data."""

    base_time: float | None  # when the last base report was measured
    scan_time: float | None  # when the last laser scan was measured
    health: str | None  # of the localization: "localized", "unsure"; anything else denies
    body_known: bool  # whether the footprint is known to be this robot's
    charging: bool  # on a charger, or the charger's state is an unknown one
    motors_enabled: bool
    stop_button: bool  # pressed, or it has switched the motors off
    stalled: bool
    bumpers: int  # bit masks of front and rear, together
    battery: float  # V
    v: float  # m/s, as the base reports
    w: float  # rad/s
    obstacles: NDArray[np.float64]  # (n, 2), m, base_link: obstacle points of all sources
    views: tuple[FieldOfView, ...] = ()  # of the sensors with fresh data; none: no driving
    overloaded: bool = False  # the agent misses its deadlines
    laser_denied: bool = False  # it is not mounted as configured, or sees parts of the robot
    unproven: bool = False  # scans have not shown yet the motion that the wheels count
    limited: bool = False  # limited mode: slow, needs no localization; all other checks apply


class GateDecision(msgspec.Struct, frozen=True):
    """Permitted command, v in m/s and w in rad/s, and the first reason if it was cut."""

    v: float
    w: float
    reason: GateReason


class SafetyGate:
    """Limits velocity commands; keeps the last one for the acceleration limits, and the latches.

    ``stops`` counts how often each denial, and each stop before an obstacle or for want of sight,
    began.
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
        # Sides to which a turn in place was stopped, +1.0 left, -1.0 right; rad turned away since.
        self._blocked_sides: dict[float, float] = {}
        self._turned = 0.0  # rad, + left, since the robot turned the other way
        # rad to the right, negative, and to the left within which the body has been.
        self._back_right: float
        self._back_left: float
        self._forget_way_back()
        self._reason = GateReason.NONE
        self.stops: Counter[GateReason] = Counter()

    def permit(self, t: float, requested: tuple[float, float], inputs: GateInputs) -> GateDecision:
        """Return the permitted part of requested (v m/s, w rad/s) at t.

        The reason is the first that applies of: those that deny all motion, a way that no
        sensor covers, an obstacle, the limited mode, an unsure pose, the speed limits, the
        acceleration limits.
        """
        self._remember(t, inputs)
        denied = self._denial(t, requested, inputs)
        if denied is not None:
            self._t = None  # start again from standstill
            return self._decided(0.0, 0.0, denied)
        if self._t is None:
            self._forget_way_back()  # the robot may have moved, or been moved, meanwhile
        elapsed = 0.0 if self._t is None else min(max(t - self._t, 0.0), _LONGEST_STEP)
        self._t = t
        self._count_turn(inputs.w * elapsed)
        v, w, slowed = self._within_speed(*requested, inputs)
        ramped = self._ramped(v, w, elapsed)
        free = self._within_sight(*ramped, inputs)
        seen = free
        if free[0] > 0.0 and not self._is_way_covered(*free, inputs):
            seen = 0.0, free[1]
        self._acceleration = max(seen[0] - self._v, 0.0) / elapsed if elapsed > 0.0 else 0.0
        if seen != free:
            return self._decided(*seen, GateReason.UNSEEN)
        if free != ramped:
            return self._decided(*free, GateReason.OBSTACLE)
        if slowed is GateReason.NONE and ramped != (v, w):
            slowed = GateReason.ACCELERATION
        return self._decided(*free, slowed)

    def expire(
        self, t: float, base_time: float | None, scan_time: float | None
    ) -> GateDecision | None:
        """Between two reports: stop if the inputs of the last command have become stale by t.

        base_time, scan_time: as in GateInputs. Returns the decision to stop; None if the last
        command was zero or is still valid.
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
        """Store the permitted command, count a new stop, and return the decision."""
        self._v, self._w = v, w
        stops = reason in DENIALS or (reason in STANDING and v == w == 0.0)
        if stops and reason is not self._reason:
            self.stops[reason] += 1
        self._reason = reason
        return GateDecision(v, w, reason)

    # ---- all or nothing -----------------------------------------------------------------------

    def _remember(self, t: float, inputs: GateInputs) -> None:
        """Update latches and battery monitor; the release of the stop button clears the latches.

        A person who has inspected the robot switches its motors off and on at the robot itself.
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
        """Return the first reason to deny all motion; None if there is none."""
        return self._unknown(t, requested, inputs) or self._unwell(requested, inputs)

    def _unknown(
        self, t: float, requested: tuple[float, float], inputs: GateInputs
    ) -> GateReason | None:
        """Return the first reason why the robot's state is unknown (stale or invalid inputs)."""
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
        if not inputs.body_known:
            return GateReason.BODY_UNKNOWN
        if inputs.overloaded:
            return GateReason.OVERLOADED
        if inputs.laser_denied:
            return GateReason.LASER_MOUNT
        located = inputs.limited or inputs.health in ("localized", "unsure")
        return None if located else GateReason.NOT_LOCALIZED

    def _unwell(self, requested: tuple[float, float], inputs: GateInputs) -> GateReason | None:
        """Return the first fault in the known state that denies all motion; None if none."""
        settings = self._settings
        if self._bumps.latched:
            return GateReason.BUMPED_AGAIN
        if self._stalls.latched:
            return GateReason.STALLED_AGAIN
        if inputs.stop_button:
            return GateReason.STOP_BUTTON
        if inputs.charging:
            return GateReason.CHARGING
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
        """Scale the requested (v m/s, w rad/s) to the speed limits, keeping its arc."""
        settings = self._settings
        limit, turn_limit, reason = (
            settings.max_speed,
            settings.max_turn_rate,
            GateReason.SPEED_LIMIT,
        )
        if inputs.health == "unsure" or inputs.unproven or inputs.limited:
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
        """Limit the change since the last permitted command; reducing v is never delayed.

        w changes only as fast as the base can follow, up and down, so that the arc that is checked
        is the arc driven. elapsed: s.
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
        """Reduce (v, w) along its arc until the robot can stop before obstacles; else only turn.

        The stopping way is that of the measured speed where this is above the commanded one.
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
                self._forget_turns()
                return v, w
            if stopping_way(inputs.v, settings.braking, 0.0) > free:
                return 0.0, 0.0  # too late to stop before the obstacle on this arc
            slow = min(v, stoppable_rate(free, settings.braking, delay))
            if slow > settings.creep_speed:
                self._forget_turns()
                return slow, w * slow / rolling
        free = turn * self._free_turn(math.copysign(turn, w), inputs)
        if free == turn:
            return 0.0, w
        slow = min(abs(w), stoppable_rate(free, settings.turn_braking, delay))
        return 0.0, math.copysign(slow, w)

    def _free_turn(self, turn: float, inputs: GateInputs) -> float:
        """Return the share, 0 to 1, of a turn in place, rad, that is free of obstacles.

        To a side to which an obstacle stopped a turn, the next one needs more room, until the robot
        drives or has turned away: else it would come nearer and nearer whenever noise shifts the
        nearest point away. Not if the turn had hardly begun; nor while scans have not shown any
        motion: what is near may be part of the robot, and only a turn tells. Back to where its body
        has been it may turn with less than the margin: what stopped a turn would hold it there.
        """
        side = np.sign(turn)  # 0.0: no turn
        more = MORE_ROOM if side in self._blocked_sides else 0.0
        back = self._back_right <= turn <= self._back_left
        share = self._body.free_share(0.0, turn, inputs.obstacles, more, back=back)
        if share > 0.0:
            self._blocked_sides.pop(side, None)
        elif side * self._turned > BEGUN and not inputs.unproven:  # stopped on its way there
            self._blocked_sides[side] = 0.0
        return share

    def _count_turn(self, turned: float) -> None:
        """Add what the robot has turned, rad; let go of the sides from which it has turned away."""
        self._turned = turned + (self._turned if self._turned * turned >= 0.0 else 0.0)
        self._back_right = min(self._back_right - turned, 0.0)
        self._back_left = max(self._back_left - turned, 0.0)
        away = {s: max(past - s * turned, 0.0) for s, past in self._blocked_sides.items()}
        self._blocked_sides = {s: angle for s, angle in away.items() if angle <= TURNED_AWAY}

    def _forget_turns(self) -> None:
        """Take the robot to be at another place, as when it drives."""
        self._blocked_sides, self._turned = {}, 0.0
        self._forget_way_back()

    def _forget_way_back(self) -> None:
        """Take the robot not to have turned yet."""
        self._back_right = self._back_left = 0.0

    def _is_way_covered(self, v: float, w: float, inputs: GateInputs) -> bool:
        """Return whether fields of view cover the front edge at the end of the stopping way."""
        settings = self._settings
        rolling = max(v, inputs.v)
        stop = stopping_way(rolling, settings.braking, settings.reaction_delay)
        return are_covered(self._body.front_edge(stop, stop * w / rolling), inputs.views)


def _all_finite(points: NDArray[np.float64]) -> bool:
    return not len(points) or bool(np.isfinite(points).all())


def _is_fresh(t: float, measured: float | None, max_age: float) -> bool:
    return measured is not None and 0.0 <= t - measured < max_age

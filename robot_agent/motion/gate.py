"""The safety gate: the last stage of every command on its way to the base. It denies by default.

The gate knows nothing of intent. It permits motion only while all it depends on is known to be
well, and only as fast as the robot can still stop before the nearest obstacle its body would
sweep over. The limited mode, for teleoperation and for a robot that is lost, asks for no pose
but is slow. v never leaves larger than wished, nor w larger than wished or last let pass.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum
from typing import Annotated

import msgspec
import numpy as np
from numpy.typing import NDArray

Positive = Annotated[float, msgspec.Meta(gt=0.0)]
NotNegative = Annotated[float, msgspec.Meta(ge=0.0)]


class GateSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Limits of the gate. The body is a rectangle round the axle's middle (Pioneer 2-DX)."""

    front: Positive = 0.21  # m from the axle to the foremost point
    rear: Positive = 0.301  # m from the axle to the rearmost point
    half_width: Positive = 0.2125  # m
    margin: NotNegative = 0.08  # m kept free beside while driving
    front_margin: NotNegative = 0.20  # m kept free ahead: room to turn round, corners reach 0.37 m
    turn_margin: NotNegative = 0.02  # m kept free round the body while turning on the spot
    max_base_age: Positive = 0.3  # s since the last base report was measured
    max_scan_age: Positive = 0.4  # s since the last laser scan was measured
    max_speed: Positive = 0.5  # m/s
    unsure_speed: NotNegative = 0.15  # m/s while the localization is unsure, or not needed
    limited_turn_rate: Positive = 0.5  # rad/s while no localization is needed
    max_turn_rate: Positive = 1.5  # rad/s
    overspeed: Positive = 0.2  # m/s (rad/s) above these limits that prove a base out of control
    reaction_delay: NotNegative = 0.25  # s from a scan until the wheels begin to brake
    braking: Positive = 0.3  # m/s2 with which the base stops
    turn_braking: Positive = 2.0  # rad/s2
    creep_speed: NotNegative = 0.02  # m/s; cut to less than this the robot may only turn
    max_acceleration: Positive = 0.5  # m/s2; slowing down is never delayed
    max_turn_acceleration: Positive = 2.0  # rad/s2, no more than the base follows


class GateReason(StrEnum):
    """Why a command was cut; NONE if it was not."""

    NONE = "none"
    INVALID = "invalid"  # a number that is none
    STALE_BASE = "stale_base"
    STALE_LASER = "stale_laser"
    NOT_LOCALIZED = "not_localized"
    MOTORS_OFF = "motors_off"
    STALLED = "stalled"
    BUMPER = "bumper"
    OVERSPEED = "overspeed"  # the base moves faster than it can have been told to
    BACKING = "backing"
    OBSTACLE = "obstacle"
    UNSURE = "unsure"
    LIMITED = "limited"  # slow, as nobody asked where the robot is
    SPEED_LIMIT = "speed_limit"
    ACCELERATION = "acceleration"


@dataclass(frozen=True, slots=True, eq=False)
class GateInputs:
    """What the gate depends on; None: never heard of."""

    base_time: float | None  # s, when the last base report was measured
    scan_time: float | None  # s, when the last laser scan was measured
    health: str | None  # of the localization: "localized", "unsure"; anything else denies
    motors_enabled: bool
    stalled: bool
    bumpers: int  # bit masks of front and rear, together
    v: float  # m/s, as the base reports
    w: float  # rad/s
    obstacles: NDArray[np.float64]  # (n, 2) m in base_link: laser returns and sonar points
    limited: bool = False  # limited mode: no localization needed, but slow; all else as ever


@dataclass(frozen=True, slots=True)
class GateDecision:
    """What may go to the base, m/s and rad/s, and the first reason why it is less than wished."""

    v: float
    w: float
    reason: GateReason


class SafetyGate:
    """Cuts commands; remembers the last it let pass, for the acceleration limits."""

    def __init__(self, settings: GateSettings) -> None:
        self._settings = settings
        self._t: float | None = None
        self._v = 0.0
        self._w = 0.0

    def permit(self, t: float, wish: tuple[float, float], inputs: GateInputs) -> GateDecision:
        """Return the permitted part of wish (v m/s, w rad/s) at t, s.

        The reasons, in order: whatever denies all motion, an obstacle, the limited mode, an
        unsure pose, the speed limits, the acceleration limits.
        """
        denied = self._denial(t, wish, inputs)
        if denied is not None:
            self._t = None  # start again from standstill
            return self._decided(0.0, 0.0, denied)
        elapsed = 0.0 if self._t is None else min(max(t - self._t, 0.0), _LONGEST_STEP)
        self._t = t
        v, w, slowed = self._within_speed(*wish, inputs)
        ramped = self._ramped(v, w, elapsed)
        free = self._within_sight(*ramped, inputs)
        if free != ramped:
            return self._decided(*free, GateReason.OBSTACLE)
        if slowed is GateReason.NONE and ramped != (v, w):
            slowed = GateReason.ACCELERATION
        return self._decided(*free, slowed)

    def _decided(self, v: float, w: float, reason: GateReason) -> GateDecision:
        self._v, self._w = v, w
        return GateDecision(v, w, reason)

    # ---- all or nothing -----------------------------------------------------------------------

    def _denial(self, t: float, wish: tuple[float, float], inputs: GateInputs) -> GateReason | None:
        """Return the first reason to deny all motion, if any."""
        settings = self._settings
        too_fast = (
            abs(inputs.v) > settings.max_speed + settings.overspeed
            or abs(inputs.w) > settings.max_turn_rate + settings.overspeed
        )
        numbers = (t, *wish, inputs.v, inputs.w)
        for reason, well in (
            (GateReason.INVALID, all(map(math.isfinite, numbers))),
            (GateReason.STALE_BASE, _is_fresh(t, inputs.base_time, settings.max_base_age)),
            (GateReason.STALE_LASER, _is_fresh(t, inputs.scan_time, settings.max_scan_age)),
            (GateReason.INVALID, bool(np.isfinite(inputs.obstacles).all())),
            (
                GateReason.NOT_LOCALIZED,
                inputs.limited or inputs.health in ("localized", "unsure"),
            ),
            (GateReason.MOTORS_OFF, inputs.motors_enabled),
            (GateReason.STALLED, not inputs.stalled),
            (GateReason.BUMPER, not inputs.bumpers),
            (GateReason.OVERSPEED, not too_fast),
            (GateReason.BACKING, wish[0] >= 0.0),
        ):
            if not well:
                return reason
        return None

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
        turn = self._settings.max_turn_acceleration * elapsed
        return (
            min(v, self._v + self._settings.max_acceleration * elapsed),
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
        turn = _stopping_way(spin, settings.turn_braking, delay)
        if rolling > settings.creep_speed:
            stop = _stopping_way(rolling, settings.braking, delay)
            arc = math.copysign(max(stop * abs(w) / rolling, turn), w)
            free = stop * self._free_share(stop, arc, inputs.obstacles)
            if free == stop:
                return v, w
            if _stopping_way(inputs.v, settings.braking, 0.0) > free:
                return 0.0, 0.0  # this arc cannot be entered any more
            slow = min(v, _stoppable_rate(free, settings.braking, delay))
            if slow > settings.creep_speed:
                return slow, w * slow / rolling
        free = turn * self._free_share(0.0, math.copysign(turn, w), inputs.obstacles)
        if free == turn:
            return 0.0, w
        slow = min(abs(w), _stoppable_rate(free, settings.turn_braking, delay))
        return 0.0, math.copysign(slow, w)

    # ---- swept body ---------------------------------------------------------------------------

    def _free_share(self, way: float, turn: float, obstacles: NDArray[np.float64]) -> float:
        """Return the share, 0 to 1, of an arc (way m, turn rad) the body can sweep freely."""
        settings = self._settings
        reach = way + settings.front + settings.rear + settings.half_width
        near = obstacles[np.abs(obstacles).max(axis=1, initial=0.0) < reach]
        if way > 0.0:
            front = settings.front + settings.front_margin
            side = settings.half_width + self._side_margin(near)
        else:
            front = settings.front + settings.turn_margin
            side = settings.half_width + settings.turn_margin
        x, y = _seen_along_arc(way * _SHARES, turn * _SHARES, near)
        rear = settings.rear + settings.turn_margin
        hit = ((x < front) & (x > -rear) & (np.abs(y) < side)).any(axis=1)
        return float(_FREE_SHARES[hit.argmax()]) if hit.any() else 1.0

    def _side_margin(self, near: NDArray[np.float64]) -> float:
        """Margin beside the body: less where an obstacle already is, or no wall could be left."""
        settings = self._settings
        x, aside = near[:, 0], np.abs(near[:, 1]) - settings.half_width
        alongside = (x < settings.front) & (x > -settings.rear)
        clearance = aside.min(where=alongside, initial=settings.margin)
        return max(float(clearance), settings.turn_margin)


_LONGEST_STEP = 0.3  # s between two commands that count for the acceleration
_POSES = 12  # per stopping way: at most 0.05 m apart at top speed, less than the margin
_SHARES = np.arange(1, _POSES + 1) / _POSES
_FREE_SHARES = np.arange(_POSES) / _POSES  # free up to the pose before the first that hits


def _is_fresh(t: float, measured: float | None, max_age: float) -> bool:
    return measured is not None and 0.0 <= t - measured < max_age


def _stopping_way(rate: float, braking: float, delay: float) -> float:
    """Way (or angle) until standstill from a rate, after a delay."""
    return rate * rate / (2.0 * braking) + rate * delay


def _stoppable_rate(way: float, braking: float, delay: float) -> float:
    """Largest rate from which the robot stops within a way: the inverse of _stopping_way."""
    return braking * (math.sqrt(delay * delay + 2.0 * way / braking) - delay)


def _seen_along_arc(
    ways: NDArray[np.float64], turns: NDArray[np.float64], points: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return (x, y), each (poses, n): points (n, 2) as seen from poses along one arc.

    ways (poses,) m and turns (poses,) rad from the start.
    """
    half = turns / 2.0
    chord = ways * np.sinc(half / np.pi)  # sinc: sin(half) / half, 1 when straight
    c, s = np.cos(turns)[:, None], np.sin(turns)[:, None]
    # The chord of an arc leaves at half the turn, which seen from its end points to -half.
    x = c * points[:, 0] + s * points[:, 1] - (chord * np.cos(half))[:, None]
    y = c * points[:, 1] - s * points[:, 0] + (chord * np.sin(half))[:, None]
    return x, y

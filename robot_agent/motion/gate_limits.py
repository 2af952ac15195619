"""All limits of the safety gate: those configured per robot, and the constant ones."""

from __future__ import annotations

import math

import msgspec

from drivers.p2os.model import DEFAULT_MODEL, load_model
from robot_agent.motion.freshness_limits import BASE, LASER

_BODY = load_model(DEFAULT_MODEL).body
_LEAST_TURN_MARGIN = 0.02  # m, ours
_HEADING = math.radians(3.0)
"""Ours: error of the laser's mount and of the pose together, by which a corner sweeps farther."""


def turn_margin(corner_reach: float) -> float:
    """Return the margin, m, of a turn in place: more for a body whose corners reach farther.

    corner_reach: from the middle of the axle to the farthest corner of the body, m.
    """
    return max(_LEAST_TURN_MARGIN, _HEADING * corner_reach)


class GateLimits(msgspec.Struct, frozen=True, kw_only=True):
    """Limits of the gate. The footprint is a rectangle round the axle's middle.

    ``gate_limits`` takes footprint and battery from the robot's model.
    """

    front: float = _BODY.front  # m from the axle to the foremost point
    rear: float = _BODY.rear  # m from the axle to the rearmost point
    half_width: float = 0.5 * _BODY.width  # m
    margin: float = 0.08  # m kept free beside while driving
    front_margin: float = 0.20  # m kept free ahead: room to turn
    # m kept free round the body while turning in place
    turn_margin: float = turn_margin(_BODY.corner_reach)
    max_base_age: float = BASE.max_age  # s since the last base report was measured
    max_scan_age: float | None = None  # s likewise of a scan; None: LASER.max_age
    max_speed: float = 0.5  # m/s
    unsure_speed: float = 0.15  # m/s while the localization is unsure, or not needed
    max_turn_rate: float = 1.5  # rad/s
    limited_turn_rate: float = 0.5  # rad/s while no localization is needed
    overspeed: float = 0.2  # m/s (rad/s) above these limits at which the base is out of control
    reaction_delay: float = 0.25  # s from a scan until the wheels begin to brake
    braking: float = 0.3  # m/s2 with which the base stops
    turn_braking: float = 2.0  # rad/s2
    creep_speed: float = 0.02  # m/s; if limited to less the robot may only turn
    max_acceleration: float = 0.5  # m/s2; slowing down is never delayed
    max_jerk: float = 2.5  # m/s3, of getting faster
    max_turn_acceleration: float = 2.0  # rad/s2, no more than the base follows
    bumps: int = 2  # within strike_window that latch until a person has inspected the robot
    stalls: int = 3  # likewise
    strike_window: float = 60.0  # s
    battery_cutoff: float = 11.0  # V
    battery_resume: float = 12.0  # V
    battery_patience: float = 2.0  # s below the cut-off: debounces the dip when motors start

    @property
    def scan_age(self) -> float:
        """Age, s, from which a scan is stale; LASER.max_age where max_scan_age is None."""
        return LASER.max_age if self.max_scan_age is None else self.max_scan_age

"""Limits of the safety gate."""

from __future__ import annotations

from typing import Annotated

import msgspec

from robot_agent.motion.freshness_limits import BASE, LASER

Positive = Annotated[float, msgspec.Meta(gt=0.0)]
NotNegative = Annotated[float, msgspec.Meta(ge=0.0)]
Count = Annotated[int, msgspec.Meta(ge=1)]


class GateSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Limits of the gate. The body is a rectangle round the axle's middle (Pioneer 2-DX)."""

    front: Positive = 0.21  # m from the axle to the foremost point
    rear: Positive = 0.301  # m from the axle to the rearmost point
    half_width: Positive = 0.2125  # m
    margin: NotNegative = 0.08  # m kept free beside while driving
    front_margin: NotNegative = 0.20  # m kept free ahead: room to turn round, corners reach 0.37 m
    turn_margin: NotNegative = 0.02  # m kept free round the body while turning on the spot
    max_base_age: Positive = BASE.max_age  # s since the last base report was measured
    max_scan_age: Positive | None = None  # s likewise of a scan; None: as the laser's rate asks
    max_speed: Positive = 0.5  # m/s
    unsure_speed: NotNegative = 0.15  # m/s while the localization is unsure, or not needed
    max_turn_rate: Positive = 1.5  # rad/s
    limited_turn_rate: Positive = 0.5  # rad/s while no localization is needed
    overspeed: Positive = 0.2  # m/s (rad/s) above these limits that prove a base out of control
    reaction_delay: NotNegative = 0.25  # s from a scan until the wheels begin to brake
    braking: Positive = 0.3  # m/s2 with which the base stops
    turn_braking: Positive = 2.0  # rad/s2
    creep_speed: NotNegative = 0.02  # m/s; cut to less than this the robot may only turn
    max_acceleration: Positive = 0.5  # m/s2; slowing down is never delayed
    max_jerk: Positive = 2.5  # m/s3, of getting faster
    max_turn_acceleration: Positive = 2.0  # rad/s2, no more than the base follows
    bumps: Count = 2  # within strike_window that a person has to look at
    stalls: Count = 3  # likewise
    strike_window: Positive = 60.0  # s
    battery_cutoff: Positive = 11.0  # V; near it the controller itself shuts down
    battery_resume: Positive = 12.0  # V
    battery_patience: NotNegative = 2.0  # s below the cut-off: motors that start pull it down

    @property
    def scan_age(self) -> float:
        """Age, s, of a scan that is too old; of the usual laser where none is set."""
        return LASER.max_age if self.max_scan_age is None else self.max_scan_age

    def __post_init__(self) -> None:
        """Refuse a battery that would be low and well at once."""
        if self.battery_resume < self.battery_cutoff:
            raise ValueError(
                f"battery_resume {self.battery_resume} V must not be below "
                f"battery_cutoff {self.battery_cutoff} V"
            )

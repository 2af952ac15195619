"""What can be set of the safety gate."""

from __future__ import annotations

from typing import Annotated

import msgspec

from robot_agent.motion.freshness_limits import scan_age_limit
from robot_agent.motion.gate_limits import GateLimits

Positive = Annotated[float, msgspec.Meta(gt=0.0)]
NotNegative = Annotated[float, msgspec.Meta(ge=0.0)]


class GateSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Body, speeds and battery of one robot, for the gate; its other limits are constants."""

    front: Positive = 0.21
    """m from the axle to the foremost point of the body"""
    rear: Positive = 0.301
    """m from the axle to the rearmost point"""
    half_width: Positive = 0.2125
    """m"""
    margin: NotNegative = 0.08
    """m kept free beside while driving"""
    max_speed: Positive = 0.5
    """m/s"""
    unsure_speed: NotNegative = 0.15
    """m/s while the localization is unsure, or not needed"""
    max_turn_rate: Positive = 1.5
    """rad/s"""
    max_scan_age: Positive | None = None
    """s since the last scan was measured; absent: as the laser's rate asks"""
    battery_cutoff: Positive = 11.0
    """V; near it the controller itself shuts down"""
    battery_resume: Positive = 12.0
    """V"""

    def __post_init__(self) -> None:
        """Refuse a battery that would be low and well at once."""
        if self.battery_resume < self.battery_cutoff:
            raise ValueError(
                f"battery_resume {self.battery_resume} V must not be below "
                f"battery_cutoff {self.battery_cutoff} V"
            )


def gate_limits(settings: GateSettings, scan_period: float | None = None) -> GateLimits:
    """Return the limits for a robot; a laser that gives a scan each period, s, sets their age."""
    limits = GateLimits(**msgspec.structs.asdict(settings))
    if settings.max_scan_age is not None or scan_period is None:
        return limits
    return msgspec.structs.replace(limits, max_scan_age=scan_age_limit(scan_period))

"""Settings of the safety gate."""

from __future__ import annotations

from typing import Annotated

import msgspec

from robot_agent.motion.freshness_limits import scan_age_limit
from robot_agent.motion.gate_limits import GateLimits

Positive = Annotated[float, msgspec.Meta(gt=0.0)]
NotNegative = Annotated[float, msgspec.Meta(ge=0.0)]
_DEFAULT = GateLimits()


class GateSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Body, speeds and battery of one robot, for the gate; its other limits are constants."""

    front: Annotated[
        Positive,
        msgspec.Meta(
            description="from the axle to the foremost point of the body", extra={"unit": "m"}
        ),
    ] = _DEFAULT.front
    rear: Annotated[
        Positive,
        msgspec.Meta(description="from the axle to the rearmost point", extra={"unit": "m"}),
    ] = _DEFAULT.rear
    half_width: Annotated[
        Positive, msgspec.Meta(description="half the body's width", extra={"unit": "m"})
    ] = _DEFAULT.half_width
    margin: Annotated[
        NotNegative, msgspec.Meta(description="kept free beside while driving", extra={"unit": "m"})
    ] = _DEFAULT.margin
    max_speed: Annotated[
        Positive, msgspec.Meta(description="limit of the forward speed", extra={"unit": "m/s"})
    ] = _DEFAULT.max_speed
    max_turn_rate: Annotated[
        Positive, msgspec.Meta(description="limit of the turning rate", extra={"unit": "rad/s"})
    ] = _DEFAULT.max_turn_rate
    battery_cutoff: Annotated[
        Positive,
        msgspec.Meta(description="near it the controller itself shuts down", extra={"unit": "V"}),
    ] = _DEFAULT.battery_cutoff
    battery_resume: Annotated[
        Positive,
        msgspec.Meta(description="from which a robot may drive again", extra={"unit": "V"}),
    ] = _DEFAULT.battery_resume

    def __post_init__(self) -> None:
        """Raise ValueError if battery_resume is below battery_cutoff."""
        if self.battery_resume < self.battery_cutoff:
            raise ValueError(
                f"battery_resume {self.battery_resume} V must not be below "
                f"battery_cutoff {self.battery_cutoff} V"
            )


def gate_limits(settings: GateSettings, scan_period: float | None = None) -> GateLimits:
    """Return the limits for a robot; scan_period, s, sets the age limit of scans if given."""
    limits = GateLimits(**msgspec.structs.asdict(settings))
    if scan_period is None:
        return limits
    return msgspec.structs.replace(limits, max_scan_age=scan_age_limit(scan_period))

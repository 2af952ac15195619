"""Settings of the safety gate."""

from __future__ import annotations

from typing import Annotated

import msgspec

from drivers.p2os.model import RobotModel
from robot_agent.motion.freshness_limits import scan_age_limit
from robot_agent.motion.gate_limits import GateLimits, turn_margin

Positive = Annotated[float, msgspec.Meta(gt=0.0)]
NotNegative = Annotated[float, msgspec.Meta(ge=0.0)]
_DEFAULT = GateLimits()
_TURNING_ROOM = 0.04  # m, ours: beyond the reach of the corners, before an obstacle ahead


class GateSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Speeds and battery of one robot, for the gate.

    Its body is that of the robot's model; the other limits are constants.
    """

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
        Positive | None,
        msgspec.Meta(
            description="near it the controller itself shuts down; unset: by the model's battery",
            extra={"unit": "V"},
        ),
    ] = None
    battery_resume: Annotated[
        Positive | None,
        msgspec.Meta(
            description="from which a robot may drive again; unset: by the model's battery",
            extra={"unit": "V"},
        ),
    ] = None

    def __post_init__(self) -> None:
        """Raise ValueError if battery_resume is below battery_cutoff."""
        cutoff, resume = self.battery_cutoff, self.battery_resume
        if cutoff is not None and resume is not None and resume < cutoff:
            raise ValueError(
                f"battery_resume {resume} V must not be below battery_cutoff {cutoff} V"
            )


def gate_limits(
    settings: GateSettings, model: RobotModel, scan_period: float | None = None
) -> GateLimits:
    """Return the limits for a robot; scan_period, s, sets the age limit of scans if given."""
    body = model.body
    front_margin = max(_DEFAULT.front_margin, body.corner_reach - body.front + _TURNING_ROOM)
    return GateLimits(
        front=body.front,
        rear=body.rear,
        half_width=0.5 * body.width,
        margin=settings.margin,
        front_margin=front_margin,
        turn_margin=turn_margin(body.corner_reach),
        max_speed=settings.max_speed,
        max_turn_rate=settings.max_turn_rate,
        battery_cutoff=settings.battery_cutoff or _DEFAULT.battery_cutoff * model.battery_share,
        battery_resume=settings.battery_resume or _DEFAULT.battery_resume * model.battery_share,
        max_scan_age=None if scan_period is None else scan_age_limit(scan_period),
    )

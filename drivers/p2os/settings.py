"""Settings of the robot base and its P2OS session."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec


class BaseSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The robot base: its serial port, model and the speed limits given to its controller."""

    url: Annotated[
        str,
        msgspec.Meta(
            description="Serial port of the base: a device, pseudo-terminal or pyserial URL"
        ),
    ] = "/dev/ttyS0"
    baud: Annotated[
        Literal[9600, 19200, 38400, 57600, 115200],
        msgspec.Meta(description="Rate of the base's line", extra={"unit": "baud"}),
    ] = 9600
    model: Annotated[
        str,
        msgspec.Meta(
            description="Model file used if the robot reports a subclass without one; its odometry"
            " noise is the default of localization.motion"
        ),
    ] = "p2dx"
    max_speed: Annotated[
        float,
        msgspec.Meta(
            gt=0.0,
            le=2.2,
            description="Largest speed the base's controller accepts",
            extra={"unit": "m/s"},
        ),
    ] = 0.5
    max_turn_rate: Annotated[
        float,
        msgspec.Meta(
            gt=0.0,
            le=8.7,
            description="Largest turn rate the base's controller accepts",
            extra={"unit": "rad/s"},
        ),
    ] = 1.75
    bump_stall: Annotated[
        Literal["off", "front", "rear", "both"],
        msgspec.Meta(description="Bumpers that stop the motors, of a robot that has any"),
    ] = "off"

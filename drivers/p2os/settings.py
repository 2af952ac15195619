"""Settings of the robot base and its P2OS session."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

Speed = Annotated[float, msgspec.Meta(gt=0.0, le=2.2)]
TurnRate = Annotated[float, msgspec.Meta(gt=0.0, le=8.7)]
Acceleration = Annotated[float, msgspec.Meta(gt=0.0, le=5.0)]
TurnAcceleration = Annotated[float, msgspec.Meta(gt=0.0, le=30.0)]


class BaseSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The robot base: its serial port, model and the motion limits given to its controller."""

    url: str = "/dev/ttyS0"  # pyserial URL, e.g. also socket:// or rfc2217://host:port
    baud: Literal[9600, 19200, 38400, 57600, 115200] = 9600
    model: str = "p2dx"  # used when the robot reports a subclass without a model file
    max_speed: Speed = 0.5  # m/s
    max_turn_rate: TurnRate = 1.75  # rad/s
    acceleration: Acceleration = 0.3  # m/s^2
    deceleration: Acceleration = 0.6  # m/s^2
    turn_acceleration: TurnAcceleration = 1.75  # rad/s^2
    turn_deceleration: TurnAcceleration = 1.75  # rad/s^2
    bump_stall: Literal["off", "front", "rear", "both"] = "off"  # bumpers that stop the motors

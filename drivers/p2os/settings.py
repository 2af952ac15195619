"""Settings of the robot base and its P2OS session."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec

from drivers.p2os.model import RobotModel

WheelScale = Annotated[float, msgspec.Meta(gt=0.8, lt=1.25)]


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
        str | None,
        msgspec.Meta(
            description="What the robot must report to be, or a model file of its own, relative to"
            " the configuration file (./mine.toml); unset: the model it reports"
        ),
    ] = None
    model_file: RobotModel | None = None
    """Content of the file that ``model`` names: filled in where the configuration is loaded."""
    wheel_scale: Annotated[
        tuple[WheelScale, WheelScale] | None,
        msgspec.Meta(
            description="Way of left and right wheel over the way counted; unset: not calibrated"
        ),
    ] = None
    track: Annotated[
        Annotated[float, msgspec.Meta(gt=0.1, lt=2.0)] | None,
        msgspec.Meta(
            description="Distance between the driven wheels, for the odometry; unset: the model's",
            extra={"unit": "m"},
        ),
    ] = None
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

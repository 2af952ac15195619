"""Robot models: conversion factors, limits and geometry, loaded from ``models/*.toml``.

A model file with ``like = "p2dx"`` holds only the differences to that shipped model.
"""

from __future__ import annotations

import math
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Annotated, Any, Literal

import msgspec

Positive = Annotated[float, msgspec.Meta(gt=0.0)]
NotNegative = Annotated[float, msgspec.Meta(ge=0.0)]
_MODELS = resources.files("drivers.p2os.models")
DEFAULT_MODEL = "p2dx"
"""Model of a robot that has not yet said what it is."""


class UnknownModelError(ValueError):
    """No model file exists for a subclass."""


class ModelFileError(ValueError):
    """A model file cannot be used; the message names file, reason and remedy."""


class Conversion(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """SI value of one wire count."""

    heading_counts: Literal[1024, 4096] = 4096  # per turn
    distance: Positive  # m per x or y count
    speed: Positive  # m/s per wheel speed count
    range: Positive  # m per sonar count
    turn: Positive  # rad/s per m/s of half the wheels' speed difference: 1 / half track


class Body(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Rectangle of the robot seen from above, in base_link, m."""

    front: Positive
    rear: Positive
    width: Positive

    @property
    def corner_reach(self) -> float:
        """Distance, m, of the farthest corner from the middle of the axle: its reach in a turn."""
        return math.hypot(max(self.front, self.rear), 0.5 * self.width)


class LaserMount(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Type of the vendor's laser and its pose in base_link.

    ignore: sectors in which it sees the robot itself, as in ``laser.ignore``.
    """

    type: Literal["lms2xx", "lms1xx", "lms500", "tim5xx", "s3series", "none"] = "lms2xx"
    upside_down: bool = False
    ignore: tuple[tuple[float, float], ...] = ()  # deg, from the scanner's right
    x: float  # m
    y: float  # m
    heading_deg: float


class OdometryNoise(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Standard deviations of the odometry per unit of motion."""

    rotation_per_rotation: NotNegative  # rad/rad
    rotation_per_translation: NotNegative  # rad/m
    translation_per_translation: NotNegative  # m/m
    translation_per_rotation: NotNegative  # m/rad


class SonarMount(msgspec.Struct, frozen=True, array_like=True, forbid_unknown_fields=True):
    """Pose of one sonar transducer in base_link."""

    x: float  # m
    y: float  # m
    heading_deg: float

    @property
    def heading(self) -> float:
        """Direction in base_link, rad."""
        return math.radians(self.heading_deg)


class RobotModel(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Conversion factors, limits and geometry of one subclass of robot.

    Source: the vendor's parameter files of the models; the odometry noise is our estimate.
    """

    subclass: str
    top_speed: Positive  # m/s
    top_turn_rate_deg: Positive  # deg/s
    sonar_far: Positive  # m, reported by a transducer without an echo
    bumper_segments: tuple[int, int] = (5, 5)  # of the front and the rear ring, where fitted
    battery: Literal[12, 24] = 12  # V, nominal, of lead-acid blocks
    sonar: tuple[SonarMount, ...]
    conversion: Conversion
    body: Body
    laser: LaserMount
    odometry_noise: OdometryNoise

    @property
    def top_turn_rate(self) -> float:
        """Fastest turn in rad/s."""
        return math.radians(self.top_turn_rate_deg)

    @property
    def battery_share(self) -> float:
        """The battery's voltage in units of a 12 V one's."""
        return self.battery / 12

    @property
    def laser_mount(self) -> tuple[float, float, float]:
        """The laser's pose in base_link: x and y in m, heading in rad."""
        return self.laser.x, self.laser.y, math.radians(self.laser.heading_deg)


def model_names() -> list[str]:
    """Return the subclasses for which a model exists."""
    files = (entry.name for entry in _MODELS.iterdir())
    return sorted(name.removesuffix(".toml") for name in files if name.endswith(".toml"))


def load_model(subclass: str) -> RobotModel:
    """Return the model of a subclass, ignoring case; raises UnknownModelError."""
    return _shipped(subclass.lower())


@cache
def _shipped(name: str) -> RobotModel:
    return msgspec.convert(_fields(name), type=RobotModel)


def load_model_file(path: Path) -> RobotModel:
    """Return the model of a file outside this package; raises ModelFileError."""
    try:
        return msgspec.convert(_merged(path.read_text(encoding="utf-8")), type=RobotModel)
    except (OSError, ValueError, OverflowError, RecursionError) as error:
        reason = getattr(error, "strerror", None) or error
        raise ModelFileError(f"{path}: {reason}; correct the model file") from error


def _fields(name: str) -> dict[str, Any]:
    """Return the whole content of a shipped model file; raises UnknownModelError."""
    if name not in model_names():
        known = ", ".join(model_names())
        raise UnknownModelError(f"robot model {name!r}: no such model, use one of {known}")
    return _merged(_MODELS.joinpath(f"{name}.toml").read_text(encoding="utf-8"))


def _merged(text: str) -> dict[str, Any]:
    """Return the content of a model file merged over that of the model named by ``like``."""
    own: dict[str, Any] = msgspec.toml.decode(text)
    base = own.pop("like", None)
    return own if base is None else _overlaid(_fields(base), own)


def _overlaid(below: dict[str, Any], above: dict[str, Any]) -> dict[str, Any]:
    """Return ``below`` with its values replaced by those of ``above``, recursively by table."""
    result = below | above
    for key, value in above.items():
        if isinstance(value, dict) and key in below:
            result[key] = _overlaid(below[key], value)
    return result

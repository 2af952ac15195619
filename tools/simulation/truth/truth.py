"""What the simulated robots and their world really are, loaded from ``worlds/*.toml``.

A file with ``like = "plain"`` holds only the differences to that shipped truth. The agent, the
drivers and the maps never read these; what they believe is in files of their own.
"""

from __future__ import annotations

import math
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Annotated, Any

import msgspec

from tools.simulation.truth.world_noise import WorldNoise

Length = Annotated[float, msgspec.Meta(gt=0.0)]
Corner = tuple[float, float]
"""x and y in base_link, m."""
_WORLDS = resources.files("tools.simulation.truth.worlds")


class TruthError(ValueError):
    """A truth cannot be used; the message names the file, the place and a remedy."""


class BodyTruth(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Rectangle of the body that can touch, about base_link, m."""

    front: Length
    rear: Length
    half_width: Length
    track: Length  # between the driven wheels


class SilhouetteTruth(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What other robots' lasers see: convex polygons at the laser's height.

    polygons: each three or more corners in base_link, m, counter-clockwise. Raises ValueError for
    any other.
    """

    polygons: tuple[tuple[Corner, ...], ...]

    def __post_init__(self) -> None:
        for number, corners in enumerate(self.polygons):
            if not _is_convex(corners):
                raise ValueError(
                    f"polygon {number} is not convex and counter-clockwise: list its corners "
                    "counter-clockwise, or split it"
                )


class LaserTruth(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How the laser really sits on the robot, and what is wrong with it.

    theta: rad, counter-clockwise. upside_down: turned over about its axis of view. mirrored: beams
    are sent in the reverse order. repeats_from: from so many s after power-on every scan is the
    first one again, with the range noise added anew; inf for never.
    """

    x: float  # m, in base_link
    y: float  # m
    theta: Annotated[float, msgspec.Meta(ge=-math.pi, le=math.pi)]
    upside_down: bool
    mirrored: bool
    repeats_from: float

    @property
    def mount(self) -> tuple[float, float, float]:
        """Pose in base_link: m, m, rad."""
        return self.x, self.y, self.theta


class BumperTruth(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Whether there are bumpers; without, their inputs are open and every bit reads 1."""

    fitted: bool


class ChargingTruth(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The charger.

    connected: the base reports a bulk charge, in the field that only later firmware has.
    """

    connected: bool


class RobotTruth(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One robot. subclass: what it says it is when a client connects."""

    subclass: str
    body: BodyTruth
    silhouette: SilhouetteTruth
    laser: LaserTruth
    bumpers: BumperTruth
    charging: ChargingTruth


class Truth(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The robots, all alike, and the world's noise. about: one line for a list of truths."""

    name: str
    about: str
    robot: RobotTruth
    noise: WorldNoise


def truth_names() -> list[str]:
    """Return the names of the shipped truths."""
    files = (entry.name for entry in _WORLDS.iterdir())
    return sorted(name.removesuffix(".toml") for name in files if name.endswith(".toml"))


@cache
def load_truth(name: str) -> Truth:
    """Return a shipped truth, or that of a file's path. Raises TruthError."""
    try:
        return msgspec.convert({"name": name, **_fields(name, ())}, Truth)
    except msgspec.ValidationError as error:
        raise TruthError(
            f"{name}: {error}; compare it with the shipped truths in tools/simulation/truth/worlds"
        ) from error


def _fields(name: str, above: tuple[str, ...]) -> dict[str, Any]:
    """Return the content of a truth merged over that of the one named by ``like``.

    above: the truths that led here by ``like``.
    """
    if name in above:
        raise TruthError(f"{above[-1]}: like = {name!r} goes in a circle; name a shipped truth")
    try:
        own: dict[str, Any] = msgspec.toml.decode(_text(name, above))
    except msgspec.DecodeError as error:
        raise TruthError(f"{name}: is not TOML ({error}); correct it there") from error
    base = own.pop("like", None)
    if base is None:
        return own
    if not isinstance(base, str):
        raise TruthError(f'{name}: like is not a name; write e.g. like = "plain"')
    return _overlaid(_fields(base, (*above, name)), own)


def _text(name: str, above: tuple[str, ...]) -> str:
    """Return the content of a shipped truth or of a file."""
    if name in truth_names():
        return _WORLDS.joinpath(f"{name}.toml").read_text(encoding="utf-8")
    where = f"{above[-1]}: like = {name!r}" if above else f"truth {name!r}"
    if not name.endswith(".toml"):
        known = ", ".join(truth_names())
        raise TruthError(f"{where}: no such truth; use a file's name ending in .toml or {known}")
    try:
        return Path(name).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise TruthError(f"{where}: cannot be read ({error}); check the path") from error


def _overlaid(below: dict[str, Any], above: dict[str, Any]) -> dict[str, Any]:
    """Return ``below`` with its values replaced by those of ``above``, recursively by table."""
    result = below | above
    for key, value in above.items():
        if isinstance(value, dict) and isinstance(below.get(key), dict):
            result[key] = _overlaid(below[key], value)
    return result


def _is_convex(corners: tuple[Corner, ...]) -> bool:
    """Return whether corners turn left everywhere, and once round in all."""
    if len(corners) < 3:
        return False
    turned = 0.0
    for (ax, ay), (bx, by), (cx, cy) in zip(
        corners, corners[1:] + corners[:1], corners[2:] + corners[:2], strict=True
    ):
        along = (bx - ax) * (cx - bx) + (by - ay) * (cy - by)
        left = (bx - ax) * (cy - by) - (by - ay) * (cx - bx)
        if left <= 0.0:
            return False
        turned += math.atan2(left, along)
    return turned < 1.5 * math.tau

"""What the simulated robots and their world really are, loaded from ``worlds/*.toml``.

A file with ``like = "rough"`` holds only the differences to that shipped truth. Its table
``[spread]`` repeats the tables above it and says how far a number may lie from what they say, for
each robot and each world drawn by the seed. The agent, the drivers and the maps never read these;
what they believe is in files of their own.
"""

from __future__ import annotations

from functools import cache
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from tools.simulation.truth.robot_truth import RobotTruth
from tools.simulation.truth.surroundings_truth import (
    FloorTruth,
    OpticsTruth,
    PeopleTruth,
    SonarTruth,
    ThingsTruth,
)
from tools.simulation.truth.world_noise import WorldNoise

_WORLDS = resources.files("tools.simulation.truth.worlds")


class TruthError(ValueError):
    """A truth cannot be used; the message names the file, the place and a remedy."""


class Truth(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The robots, all of one kind, and the world. about: one line for a list of truths.

    spread: largest differences from the other values, uniformly distributed, in tables of the same
    names.
    """

    name: str
    about: str
    robot: RobotTruth
    noise: WorldNoise
    optics: OpticsTruth
    sonar: SonarTruth
    floor: FloorTruth
    things: ThingsTruth
    people: PeopleTruth
    spread: dict[str, Any] = {}

    def drawn(self, rng: np.random.Generator) -> Truth:
        """Return one truth of those that the spread allows; this one itself without any spread."""
        if not self.spread:
            return self
        own = msgspec.to_builtins(self)
        del own["spread"]
        return msgspec.convert(_moved(own, self.spread, rng.uniform), Truth)


def truth_names() -> list[str]:
    """Return the names of the shipped truths."""
    return sorted(_shipped())


@cache
def load_truth(name: str) -> Truth:
    """Return a shipped truth, or that of a file's path. Raises TruthError."""
    fields = {"name": name, **_fields(name, ())}
    remedy = "compare it with the shipped truths in tools/simulation/truth/worlds"
    try:
        truth = msgspec.convert(fields, Truth)
        spread, plain = truth.spread, {**fields, "spread": {}}
        for end in (-1.0, 1.0):
            msgspec.convert(_moved(plain, spread, lambda _low, high, end=end: end * high), Truth)
    except msgspec.ValidationError as error:
        raise TruthError(f"{name}: {error}; {remedy}") from error
    except _SpreadError as error:
        raise TruthError(f"{name}: {error}; name a number of the tables above it") from error
    return truth


class _SpreadError(ValueError):
    """A spread is of something that is no number."""


def _moved(values: dict[str, Any], spread: dict[str, Any], draw: Any, at: str = "") -> Any:
    """Return values with each number of the spread moved by ``draw(-number, number)``."""
    result = dict(values)
    for key, wide in spread.items():
        place, value = f"{at}{key}", values.get(key)
        if isinstance(wide, dict) and isinstance(value, dict):
            result[key] = _moved(value, wide, draw, f"{place}.")
        elif value is not None and _is_number(wide) and _is_number(value):
            result[key] = value + float(draw(-wide, wide))
        else:
            raise _SpreadError(f"spread.{place} is a spread of nothing")
    return result


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


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
        raise TruthError(f'{name}: like is not a name; write e.g. like = "rough"')
    return _overlaid(_fields(base, (*above, name)), own)


def _text(name: str, above: tuple[str, ...]) -> str:
    """Return the content of a shipped truth or of a file."""
    shipped = _shipped()
    if name in shipped:
        return shipped[name].read_text(encoding="utf-8")
    where = f"{above[-1]}: like = {name!r}" if above else f"truth {name!r}"
    if not name.endswith(".toml"):
        known = ", ".join(truth_names())
        raise TruthError(f"{where}: no such truth; use a file's name ending in .toml or {known}")
    try:
        return Path(name).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise TruthError(f"{where}: cannot be read ({error}); check the path") from error


@cache
def _shipped() -> dict[str, Traversable]:
    """Return the shipped files by name: the worlds, and the robots of every model."""
    files = [*_WORLDS.iterdir(), *_WORLDS.joinpath("models").iterdir()]
    return {file.name[:-5]: file for file in files if file.name.endswith(".toml")}


def _overlaid(below: dict[str, Any], above: dict[str, Any]) -> dict[str, Any]:
    """Return ``below`` with its values replaced by those of ``above``, recursively by table."""
    result = below | above
    for key, value in above.items():
        if isinstance(value, dict) and isinstance(below.get(key), dict):
            result[key] = _overlaid(below[key], value)
    return result

"""Mutation test of the safety gate against its table of cases.

Every mutant of the gate's modules is run in this process on the cases of
``tests/robot_agent/motion/gate_cases.py`` until one of them fails. Equivalent mutants, which no
case can kill, are listed in ``SURVIVORS`` with the reason.
"""

from __future__ import annotations

import ast
import importlib.util
import inspect
import sys
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

from robot_agent.motion import (
    battery_watch,
    gate,
    gate_limits,
    gate_reason,
    repeated_fault_latch,
    stopping,
    swept_footprint,
)
from tools.quality.mutation import mutants

PARTS = (
    gate_reason,
    gate_limits,
    stopping,
    swept_footprint,
    repeated_fault_latch,
    battery_watch,
    gate,
)
"""The gate's modules, each after those it imports."""

_EDGE = "differs only for a point exactly on an edge, which rounding decides"
_ONE_SPEED = "differs at one speed only, whose stopping way is the limit to the last bit"
_AT_LIMIT = "no difference: the share is 1 at the limit"
_OTHER_SHARE = "no difference: the minimum takes the other share, at most 1"
_FIRST_STEP = "no difference: the first step takes no time and sets the acceleration to 0"
_DRIVING = "no difference: only the check of a turn uses it, and the gate names it there"
_LARGER_BODY = "differs for larger bodies only; a test of the gate's settings has its value"
SURVIVORS = [
    ("gate_limits.3.0 -> 2.7", _LARGER_BODY),
    ("swept_footprint.free_share: False -> True", _DRIVING),
    ("swept_footprint.free_share: 0.0 -> 1.0", _DRIVING),
    ("swept_footprint.free_share: 0.0 -> -1.0", _DRIVING),
    ("swept_footprint.free_share: x < front -> x <= front", _EDGE),
    ("swept_footprint.free_share: x > -rear -> x >= -rear", _EDGE),
    ("swept_footprint.free_share: way <= self._edging_way -> way < self._edging_way", _ONE_SPEED),
    (
        "swept_footprint.free_share: np.maximum(*np.abs(obstacles.T)) < reach -> "
        "np.maximum(*np.abs(obstacles.T)) <= reach",
        "no difference: the reach is longer than anything the body can sweep",
    ),
    ("gate._within_speed: abs(w) > turn_limit -> abs(w) >= turn_limit", _AT_LIMIT),
    ("gate._within_speed: v > limit -> v >= limit", _AT_LIMIT),
    ("gate._within_speed: 1.0 -> 2.0", _OTHER_SHARE),
    ("gate._within_speed: 1.0 -> 2.0", _OTHER_SHARE),
    ("gate.__init__: 0.0 -> 1.0", _FIRST_STEP),
    ("gate.__init__: 0.0 -> -1.0", _FIRST_STEP),
]
"""Equivalent mutants and the reason; equal names are different places in the code."""


class MutationError(ValueError):
    """The mutation test cannot be run; the message names the reason."""


@dataclass(frozen=True, slots=True)
class Verdict:
    """Result of one mutant: killed, or not."""

    mutant: str
    killed: bool


def load_cases() -> ModuleType:
    """Return the module of the table of cases, which only a checkout has.

    Raises MutationError.
    """
    path = Path(__file__).parents[2] / "tests" / "robot_agent" / "motion" / "gate_cases.py"
    if not path.exists():
        raise MutationError(f"{path}: not there; run this from a checkout, not an installation")
    spec = importlib.util.spec_from_file_location("gate_case_table", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    return module


def mutant_names() -> list[str]:
    """Return the names of all mutants, in the order of ``judge``."""
    return [name for part in PARTS for name in _mutants_of(part, _parsed(part))]


def judge(cases: ModuleType, every: int = 1, first: int = 0) -> Iterator[Verdict]:
    """Yield the verdict of each mutant, or of those numbered first, first + every and so on.

    first: at most every - 1. Raises MutationError if the original fails its cases.
    """
    trees = {part: _parsed(part) for part in PARTS}
    if _killed(cases, trees):
        raise MutationError("the gate itself fails its cases; correct that first")
    number = 0
    for part in PARTS:
        for name in _mutants_of(part, trees[part]):
            if number % every == first:
                yield Verdict(name, _killed(cases, trees))
            number += 1


def unexplained(survivors: list[str]) -> list[str]:
    """Return the survivors that ``SURVIVORS`` does not list."""
    known = [name for name, _ in SURVIVORS]
    return [name for name in survivors if name not in known]


def _parsed(part: ModuleType) -> ast.Module:
    return ast.parse(inspect.getsource(part))


def _mutants_of(part: ModuleType, tree: ast.Module) -> Iterator[str]:
    short = part.__name__.rpartition(".")[2]
    for name in mutants(tree):
        yield f"{short}.{name}"


def _killed(cases: ModuleType, trees: dict[ModuleType, ast.Module]) -> bool:
    """Return whether a case fails on a gate built from these trees."""
    originals = {part.__name__: sys.modules[part.__name__] for part in PARTS}
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return not cases.all_hold(_built(trees))
    except Exception:  # noqa: BLE001 - a mutant that raises is killed too
        return True
    finally:
        sys.modules.update(originals)


def _built(trees: dict[ModuleType, ast.Module]) -> ModuleType:
    """Build the gate's modules from trees and put them into sys.modules; return the gate's."""
    for part, tree in trees.items():
        module = ModuleType(part.__name__)
        sys.modules[part.__name__] = module
        exec(compile(tree, "<mutant>", "exec"), module.__dict__)  # noqa: S102 - our own code, mutated
    return sys.modules[gate.__name__]

"""The rule file: fuzzy sets and the paper's Table I in TOML, checked and built into a fuzzy system.

A set is defined by scikit-fuzzy's membership functions of its break points. It is evaluated exactly
by ``fuzzy.Trapezoid``; a file on which the two differ is refused.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise, product
from pathlib import Path
from typing import Any

import numpy as np

from robot_agent.light_import import import_lightly
from robot_agent.patrol.actions import Action
from robot_agent.patrol.fuzzy import MamdaniSystem, Rule, Trapezoid, Variable

_membership = import_lightly("skfuzzy.membership")

RULES_FILE = Path(__file__).with_name("rules.toml")

_BORDER = "distance_from_border"
_NEIGHBOR = "distance_from_neighbor"
_STATE = "neighbor_state"
_LEFT_END = "distance_from_left_end"
_RIGHT_END = "distance_from_right_end"

_LEVELS = ("low", "medium", "high")
_STATES = ("patrolling_on_my_left", "not_patrolling", "patrolling_on_my_right")
_SETS: dict[str, tuple[str, ...]] = {
    _BORDER: _LEVELS,
    _NEIGHBOR: _LEVELS,
    _STATE: _STATES,
    _LEFT_END: ("low", "high"),
    _RIGHT_END: ("low", "high"),
    "level": _LEVELS,
}
_RANGES = {_STATE: (-1.0, 1.0), "level": (0.0, 1.0)}
_DISTANCES = (0.0, math.inf)  # range of every other input
_OUTPUTS = {
    "RFL": Action.REACH_FRONTIER,
    "KGL": Action.KEEP_GOING,
    "PCWL": Action.PATROL_CLOCKWISE,
    "PCCWL": Action.PATROL_COUNTER_CLOCKWISE,
    "ATL": Action.AVOID_TEAMMATE,
}
_TABLES = tuple(f"border_{level}" for level in _LEVELS)
_CELLS = tuple(f"neighbor_{level}" for level in _LEVELS)
_READINGS = ("R1", "R2", "R3")
_END_INPUTS = {"left_end_low": _LEFT_END, "right_end_low": _RIGHT_END}

_Cell = tuple[str, str, str]  # set of border, of neighbor state, of neighbor
_Levels = dict[Action, str]  # the outputs a cell names, the others are low


class RulesError(ValueError):
    """An unusable rule file; the message is one line that names file, place and remedy."""


def check_rules(path: Path, *, safety_distance: float) -> None:
    """Check a rule file in every reading it has, for closed and open borders.

    safety_distance: d_s, m. Raises RulesError.
    """
    file = _RuleFile(path)
    for reading, open_border in product(file.readings(), (False, True)):
        file.system(reading, safety_distance, open_border=open_border)


def load_rules(
    path: Path, *, reading: str, safety_distance: float, open_border: bool
) -> MamdaniSystem:
    """Load a rule file as a fuzzy system whose outputs are the actions.

    reading: name of the reading of the damaged cell. safety_distance: d_s of Teammate Avoidance,
    m, checked against the sets. open_border: adds the two inputs and the rules of its ends.

    Raises RulesError.
    """
    return _RuleFile(path).system(reading, safety_distance, open_border=open_border)


class _RuleFile:
    """One parsed file, with its path for messages."""

    def __init__(self, path: Path) -> None:
        self._path = path
        try:
            self._content = tomllib.loads(path.read_text(encoding="utf-8"))
        except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
            raise self._error("file", f"{error}, give a readable TOML file") from error
        self._check_names("file", self._content, {"sets", *_TABLES}, {"reading", "open_border"})

    def system(self, reading: str, safety_distance: float, *, open_border: bool) -> MamdaniSystem:
        """Build the fuzzy system."""
        variables = self._variables()
        self._check_safety_distance(variables[_NEIGHBOR], safety_distance)
        cells = self._cells(reading)
        for cell, named in cells.items():
            self._check_cell(_cell_place(cell), cell, named, variables)
        rules = [_cell_rule(cell, named) for cell, named in cells.items()]
        names = [_BORDER, _NEIGHBOR, _STATE]
        if open_border:
            rules = [rule for old in rules for rule in _at_ends(old)]
            rules += self._end_rules(variables)
            names += [_LEFT_END, _RIGHT_END]
        levels = variables["level"].sets
        outputs = [Variable(action.value, levels) for action in Action]
        return MamdaniSystem([variables[name] for name in names], outputs, rules)

    def readings(self) -> tuple[str, ...]:
        """Return the readings the file defines; the first known one if it defines none."""
        return tuple(self._table("reading", self._content, {})) or _READINGS[:1]

    # ---- fuzzy sets ---------------------------------------------------------------------------

    def _variables(self) -> dict[str, Variable]:
        sets = self._table("sets", self._content)
        self._check_names("[sets]", sets, set(_SETS))
        return {name: self._variable(name, self._table(name, sets)) for name in _SETS}

    def _variable(self, name: str, sets: Mapping[str, Any]) -> Variable:
        place = f"[sets.{name}]"
        self._check_names(place, sets, set(_SETS[name]))
        variable = Variable(
            name, {key: self._fuzzy_set(f"{place} {key}", sets[key]) for key in _SETS[name]}
        )
        curves = list(variable.sets.values())
        for (low, high), one, other in zip(
            pairwise(variable.sets), curves, curves[1:], strict=False
        ):
            if one.b > other.b or one.c > other.c:
                raise self._error(place, f"{low} lies above {high}, put the sets in order")
        lowest, highest = _RANGES.get(name, _DISTANCES)
        for x in _probes(curves, lowest, highest):
            if not any(s(x) > 0.0 for s in curves):
                raise self._error(place, f"no set covers {x:g}, make neighboring sets overlap")
        if name == "level" and any(s.a < lowest or s.d > highest for s in curves):
            raise self._error(place, "a set leaves 0 to 1, keep all break points inside")
        return variable

    def _fuzzy_set(self, place: str, points: Any) -> Trapezoid:
        if (
            not isinstance(points, list)
            or len(points) not in (3, 4)
            or not all(isinstance(x, int | float) and not math.isnan(x) for x in points)
        ):
            raise self._error(place, "no fuzzy set, give 3 numbers (triangle) or 4 (trapezoid)")
        try:
            return _fuzzy_set([float(x) for x in points])
        except ValueError as error:
            raise self._error(place, str(error)) from error

    def _check_safety_distance(self, neighbor: Variable, safety_distance: float) -> None:
        medium, high = neighbor.sets["medium"], neighbor.sets["high"]
        crossing = _crossing(medium, high)
        if safety_distance < crossing:
            raise self._error(
                f"[sets.{_NEIGHBOR}]",
                f"medium and high cross at {crossing:.2f} m, beyond the safety distance "
                f"{safety_distance:.2f} m where robots would stop for good; raise safety_distance "
                "or move the sets",
            )

    def _check_cell(
        self, place: str, cell: _Cell, named: _Levels, variables: Mapping[str, Variable]
    ) -> None:
        """Refuse a rule that never fires, selects no action, or avoids a teammate however far."""
        for variable, key in zip((_BORDER, _STATE, _NEIGHBOR), cell, strict=True):
            self._check_reachable(place, variables[variable], key)
        if all(level == "low" for level in named.values()):
            raise self._error(place, "chooses nothing, name an output that is medium or high")
        avoids = named.get(Action.AVOID_TEAMMATE, "low") != "low"
        if avoids and cell[2] == "high":
            raise self._error(
                place,
                "avoids a teammate however far, where it would not move; choose another output",
            )

    def _check_reachable(self, place: str, variable: Variable, key: str) -> None:
        lowest, highest = _RANGES.get(variable.name, _DISTANCES)
        fuzzy_set = variable.sets[key]
        if fuzzy_set.c < lowest or fuzzy_set.b > highest:
            raise self._error(
                place,
                f"can never hold: [sets.{variable.name}] {key} is full only outside "
                f"{lowest:g} to {highest:g}, move the set",
            )

    # ---- table of rules -----------------------------------------------------------------------

    def _cells(self, reading: str) -> dict[_Cell, _Levels]:
        """Return every cell of the table, with the overrides of the reading applied."""
        readings = self._table("reading", self._content, {})
        self._check_names("[reading]", readings, set(), set(_READINGS))
        if readings and reading not in readings:
            raise self._error("[reading]", f"has no {reading}, add it or choose another")
        cells: dict[_Cell, _Levels] = {}
        for name in ("", *readings):
            overrides = self._table(name, readings) if name else self._content
            place = f"reading.{name}." if name else ""
            if name:
                self._check_names(f"[reading.{name}]", overrides, set(), set(_TABLES))
            found = dict(self._cells_of(place, overrides))
            if not name or name == reading:
                cells |= found
        for border, state, neighbor in product(_LEVELS, _STATES, _LEVELS):
            if (border, state, neighbor) not in cells:
                raise self._error(
                    f"[border_{border}.{state}]", f"neighbor_{neighbor} is missing, add the cell"
                )
        return cells

    def _cells_of(self, prefix: str, tables: Mapping[str, Any]) -> Iterator[tuple[_Cell, _Levels]]:
        for table in (name for name in _TABLES if name in tables):
            place = f"[{prefix}{table}"
            states = self._table(table, tables)
            self._check_names(f"{place}]", states, set(), set(_STATES))
            for state in states:
                row = self._table(state, states)
                self._check_names(f"{place}.{state}]", row, set(), set(_CELLS))
                for cell, text in row.items():
                    levels = self._levels(f"{place}.{state}] {cell}", text)
                    yield (_last(table), state, _last(cell)), levels

    def _levels(self, place: str, text: Any) -> _Levels:
        """Parse the outputs of a cell, such as "ATL high, PCWL medium"."""
        levels: _Levels = {}
        for part in text.split(",") if isinstance(text, str) else [""]:
            words = part.split()
            if len(words) != 2 or words[0] not in _OUTPUTS or words[1] not in _LEVELS:
                raise self._error(
                    place,
                    f"{part.strip()!r} is no output and level, write one of "
                    f"{', '.join(_OUTPUTS)} and one of {', '.join(_LEVELS)}",
                )
            if _OUTPUTS[words[0]] in levels:
                raise self._error(place, f"says {words[0]} twice, keep one")
            levels[_OUTPUTS[words[0]]] = words[1]
        return levels

    def _end_rules(self, variables: Mapping[str, Variable]) -> Iterator[Rule]:
        """Yield the rules for the ends of an open border, for each border and neighbor set."""
        table = self._table("open_border", self._content, {})
        self._check_names("[open_border]", table, {"border", "neighbor", *_END_INPUTS})
        for key in ("border", "neighbor"):
            listed = table[key]
            if not (isinstance(listed, list) and listed and all(x in _LEVELS for x in listed)):
                raise self._error(f"[open_border] {key}", f"list some of {', '.join(_LEVELS)}")
        for border, neighbor, (key, end) in product(
            table["border"], table["neighbor"], _END_INPUTS.items()
        ):
            place = f"[open_border] {key}"
            named = self._levels(place, table[key])
            self._check_cell(place, (border, _STATES[0], neighbor), named, variables)
            self._check_reachable(place, variables[end], "low")
            when = ((_BORDER, border), (_NEIGHBOR, neighbor), (end, "low"))
            yield Rule(when, _consequents(named))

    # ---- messages -----------------------------------------------------------------------------

    def _table(
        self, name: str, parent: Mapping[str, Any], default: dict[str, Any] | None = None
    ) -> dict[str, Any]:
        table = parent.get(name, default)
        if not isinstance(table, dict):
            raise self._error(name, "no table, write it as [...]")
        return table

    def _check_names(
        self,
        place: str,
        table: Mapping[str, Any],
        required: set[str],
        optional: set[str] | frozenset[str] = frozenset(),
    ) -> None:
        known = required | optional
        for name in table:
            if name not in known:
                raise self._error(place, f"unknown name {name!r}, use {', '.join(sorted(known))}")
        for name in sorted(required - set(table)):
            raise self._error(place, f"{name} is missing, add it")

    def _error(self, place: str, problem: str) -> RulesError:
        return RulesError(f"{self._path}: {place}: {' '.join(problem.split())}")


def _cell_place(cell: _Cell) -> str:
    border, state, neighbor = cell
    return f"[border_{border}.{state}] neighbor_{neighbor}"


def _fuzzy_set(points: Sequence[float]) -> Trapezoid:
    """Return the set of skfuzzy's triangle of 3 points or trapezoid of 4.

    Raises ValueError if the points do not ascend, or if skfuzzy's degree is undefined or differs
    from the exact evaluation at a point, between two, or beside them.
    """
    a, b, *c, d = points
    try:
        exact = Trapezoid(a, b, c[0] if c else b, d)
    except ValueError as error:
        raise ValueError(f"{error}, put them in order") from error
    corners = sorted({x for x in points if math.isfinite(x)} or {0.0})
    between = [(x + y) / 2.0 for x, y in pairwise(corners)]
    places = [corners[0] - 1.0, *corners, *between, corners[-1] + 1.0]
    shape = _membership.trapmf if c else _membership.trimf
    with np.errstate(invalid="ignore"):  # infinity minus infinity is NaN, detected below
        degrees = shape(np.array(places), np.array(points)).tolist()
    for x, degree in zip(places, degrees, strict=True):
        if degree != exact(x):
            raise ValueError(f"gives no degree at {x:g}, let no side rise or fall for ever")
    return exact


def _probes(sets: Sequence[Trapezoid], lowest: float, highest: float) -> list[float]:
    """Return the values at which to look for gaps between sets: corners, and one between any two.

    Between two corners every set is linear, so a gap that contains neither spans the interval.
    """
    corners = {lowest, highest} | {x for s in sets for x in (s.a, s.b, s.c, s.d)}
    inside = sorted(x for x in corners if lowest <= x <= highest)
    between = [x + 1.0 if y == math.inf else (x + y) / 2.0 for x, y in pairwise(inside)]
    return [*inside, *between]


def _cell_rule(cell: _Cell, named: _Levels) -> Rule:
    border, state, neighbor = cell
    when = ((_BORDER, border), (_STATE, state), (_NEIGHBOR, neighbor))
    return Rule(when, _consequents(named))


def _consequents(named: _Levels) -> tuple[tuple[str, str], ...]:
    return tuple((action.value, named.get(action, "low")) for action in Action)


def _at_ends(rule: Rule) -> Sequence[Rule]:
    """Return a rule split for an open border: Keep Going only far from both ends.

    A rule without Keep Going is returned as it is; near an end the others lose that output.
    """
    keep_going = Action.KEEP_GOING.value
    if (keep_going, "low") in rule.then:
        return (rule,)
    without = tuple((o, "low" if o == keep_going else level) for o, level in rule.then)
    return (
        Rule((*rule.when, (_LEFT_END, "high"), (_RIGHT_END, "high")), rule.then),
        Rule((*rule.when, (_LEFT_END, "low")), without),
        Rule((*rule.when, (_RIGHT_END, "low")), without),
    )


def _crossing(falling: Trapezoid, rising: Trapezoid) -> float:
    """Return the value at which the falling side of one set meets the rising side of the next."""
    fall, rise = falling.d - falling.c, rising.b - rising.a
    if fall + rise == 0.0:
        return rising.a
    return (falling.d * rise + rising.a * fall) / (fall + rise)


def _last(name: str) -> str:
    return name.rsplit("_", 1)[1]

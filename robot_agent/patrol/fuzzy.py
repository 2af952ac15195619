"""A Mamdani fuzzy system, evaluated exactly: min for and, max for or, centroid defuzzification.

The centroid is not sampled. The aggregated output max_i min(strength_i, mu_i(z)) is integrated by
inclusion and exclusion over the sets that overlap; each overlap, cut at a height, has an area and
a moment that are polynomials of that height.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain, combinations, pairwise
from types import MappingProxyType
from typing import NamedTuple

_NO_HEIGHT = 1e-12  # an overlap lower than this is empty


@dataclass(frozen=True, slots=True)
class Trapezoid:
    """A fuzzy set: 0 up to a, rising to 1 at b, 1 up to c, falling to 0 at d (b = c: a triangle).

    a <= b <= c <= d; a = b or c = d is a vertical edge. c and d may be infinite.
    """

    a: float
    b: float
    c: float
    d: float

    def __post_init__(self) -> None:
        if not self.a <= self.b <= self.c <= self.d:
            raise ValueError(f"break points {self.a}, {self.b}, {self.c}, {self.d} do not ascend")

    def __call__(self, x: float) -> float:
        """Return the degree, 0 to 1, to which x belongs to the set."""
        if self.b <= x <= self.c:
            return 1.0
        if self.a < x < self.b:
            return (x - self.a) / (self.b - self.a)
        if self.c < x < self.d:
            return (self.d - x) / (self.d - self.c)
        return 0.0


@dataclass(frozen=True, slots=True)
class Variable:
    """A linguistic variable: a name and its fuzzy sets by name."""

    name: str
    sets: Mapping[str, Trapezoid]


@dataclass(frozen=True, slots=True)
class Rule:
    """If every (input, set) of ``when`` holds, then every (output, set) of ``then``."""

    when: tuple[tuple[str, str], ...]
    then: tuple[tuple[str, str], ...]


_NumberedRule = tuple[tuple[int, ...], tuple[int, ...]]
"""A rule by the numbers of its input and output sets."""


class MamdaniSystem:
    """A fuzzy rule base over named inputs and outputs.

    inputs, outputs: variables; the sets of an output must be finite. rules: any number, each
    naming any inputs and outputs. Raises KeyError for a rule with an unknown name.
    """

    def __init__(
        self, inputs: Sequence[Variable], outputs: Sequence[Variable], rules: Sequence[Rule]
    ) -> None:
        self.inputs, self.outputs, self.rules = tuple(inputs), tuple(outputs), tuple(rules)
        self._input_sets: list[tuple[str, int, tuple[Trapezoid, ...]]] = []  # and its first degree
        for variable in inputs:
            first = sum(len(sets) for *_, sets in self._input_sets)
            self._input_sets.append((variable.name, first, tuple(variable.sets.values())))
        inside, outside = _indices(self.inputs), _indices(self.outputs)
        self._rules: list[_NumberedRule] = [
            (tuple(inside[key] for key in rule.when), tuple(outside[key] for key in rule.then))
            for rule in rules
        ]
        self._live_rules: list[_NumberedRule] | None = None  # of nonzero degree; None: outdated
        self._output_sets = len(outside)
        named: dict[tuple[Trapezoid, ...], list[tuple[str, int, int]]] = {}  # of equal sets
        first = 0
        for output in outputs:
            sets = tuple(output.sets.values())
            named.setdefault(sets, []).append((output.name, first, first + len(sets)))
            first += len(sets)
        self._outputs = [(Centroid(sets), own) for sets, own in named.items()]
        self._values: dict[str, float] = {}  # of the inputs at the last evaluation
        self._degrees = [math.nan] * len(inside)  # of their sets
        self._last: Mapping[str, float] = {}

    def evaluate(self, values: Mapping[str, float]) -> Mapping[str, float]:
        """Return the centroid of every output, for a value of every input (may be infinite).

        An output that no active rule names is 0. While no degree changes (a robot alone on its
        border) the same mapping object is returned. Raises KeyError if an input is missing.
        """
        changed = False
        for name, first, sets in self._input_sets:
            value = values[name]
            if value == self._values.get(name):
                continue
            self._values[name] = value
            for index, fuzzy_set in enumerate(sets, first):
                degree, before = fuzzy_set(value), self._degrees[index]
                if degree != before:
                    self._degrees[index], changed = degree, True
                    if not (degree and before):
                        self._live_rules = None
        if changed:
            self._last = MappingProxyType(self._levels(self._set_strengths(self._degrees)))
        return self._last

    def _set_strengths(self, degrees: Sequence[float]) -> list[float]:
        """Return (output sets,) the greatest degree of a rule that names the output set."""
        if self._live_rules is None:
            self._live_rules = [
                (when, then) for when, then in self._rules if all(degrees[index] for index in when)
            ]
        strengths = [0.0] * self._output_sets
        for when, then in self._live_rules:
            strength = 1.0
            for index in when:
                degree = degrees[index]
                if degree < strength:
                    strength = degree
            for index in then:
                if strengths[index] < strength:
                    strengths[index] = strength
        return strengths

    def _levels(self, strengths: Sequence[float]) -> dict[str, float]:
        """Return the centroid of each output; equal strengths are evaluated once."""
        levels: dict[str, float] = {}
        for centroid, outputs in self._outputs:
            found: dict[tuple[float, ...], float] = {}
            for name, first, last in outputs:
                own = tuple(strengths[first:last])
                level = found.get(own)
                if level is None:
                    level = found[own] = centroid.of(own)
                levels[name] = level
        return levels


def _indices(variables: Sequence[Variable]) -> dict[tuple[str, str], int]:
    """Number all sets of all variables, by (variable, set)."""
    return {key: i for i, key in enumerate((v.name, name) for v in variables for name in v.sets)}


class Layer(NamedTuple):
    """One layer of an overlap of sets, with its integrals from its bottom up to a height h.

    area = h (area1 + h area2), moment = h (moment1 + h (moment2 + h moment3)); the sign is in them.
    """

    first: int  # of the sets that overlap
    others: tuple[int, ...]
    bottom: float
    height: float
    integrals: tuple[float, float, float, float, float]  # area1, area2, moment1, moment2, moment3


class Centroid:
    """Centroid of an output from the strengths of its sets.

    Area under max_i min(s_i, mu_i) = sum over groups of sets of (-1)^(size + 1) times the area
    under min over the group of mu_i, cut at min over the group of s_i. Such an overlap is a stack
    of layers between heights h0 and h1 whose ends move linearly with the height.
    """

    def __init__(self, sets: tuple[Trapezoid, ...]) -> None:
        self.layers = [
            _integrated(group, layer)
            for group in _groups(len(sets))
            for layer in _layers([sets[i] for i in group])
        ]

    def of(self, strengths: Sequence[float]) -> float:
        """Return the centroid of strengths (sets,); 0 where all are 0."""
        area = moment = 0.0
        for first, others, bottom, height, integrals in self.layers:
            h = strengths[first]
            if h <= bottom:
                continue
            for other in others:
                strength = strengths[other]
                if strength < h:
                    h = strength
            h -= bottom
            if h > 0.0:
                if h > height:
                    h = height
                area1, area2, moment1, moment2, moment3 = integrals
                area += h * (area1 + h * area2)
                moment += h * (moment1 + h * (moment2 + h * moment3))
        return moment / area if area > 0.0 else 0.0


def _integrated(
    group: tuple[int, ...], layer: tuple[float, float, float, float, float, float]
) -> Layer:
    """Prepare a layer's integrals.

    width(h) = right - left + (right_slope - left_slope) h, and the same for the moment
    (right(h)^2 - left(h)^2) / 2, integrated over the height from 0 to h.
    """
    h0, h1, left, left_slope, right, right_slope = layer
    sign = 1.0 if len(group) % 2 else -1.0
    return Layer(
        group[0],
        group[1:],
        h0,
        h1 - h0,
        (
            sign * (right - left),
            sign * (right_slope - left_slope) / 2.0,
            sign * (right**2 - left**2) / 2.0,
            sign * (right * right_slope - left * left_slope) / 2.0,
            sign * (right_slope**2 - left_slope**2) / 6.0,
        ),
    )


def _groups(count: int) -> Iterator[tuple[int, ...]]:
    return chain.from_iterable(combinations(range(count), size) for size in range(1, count + 1))


def _layers(
    sets: Sequence[Trapezoid],
) -> list[tuple[float, float, float, float, float, float]]:
    """Split the overlap of sets into layers (h0, h1, left, left slope, right, right slope).

    At height h0 + h the overlap reaches from left + slope * h to right + slope * h.
    """
    top = _overlap_height(sets)
    if top <= _NO_HEIGHT:
        return []
    heights = sorted({0.0, top, *(h for h in _side_crossings(sets) if 0.0 < h < top)})
    layers = []
    for h0, h1 in pairwise(heights):
        (left0, right0), (left1, right1) = _ends(sets, h0), _ends(sets, h1)
        rise = h1 - h0
        layers.append((h0, h1, left0, (left1 - left0) / rise, right0, (right1 - right0) / rise))
    return layers


def _ends(sets: Sequence[Trapezoid], h: float) -> tuple[float, float]:
    """Ends of the interval where every set is at least h."""
    left = max(s.a + h * (s.b - s.a) for s in sets)
    right = min(s.d - h * (s.d - s.c) for s in sets)
    return left, right


def _overlap_height(sets: Sequence[Trapezoid]) -> float:
    """Greatest h at which the sets still overlap: where a rising side meets a falling one."""
    top = 1.0
    for rising in sets:
        for falling in sets:
            slope = (rising.b - rising.a) + (falling.d - falling.c)
            room = falling.d - rising.a
            if room <= 0.0:
                return 0.0
            if room < slope:
                top = min(top, room / slope)
    return top


def _side_crossings(sets: Sequence[Trapezoid]) -> Iterator[float]:
    """Heights at which two rising or two falling sides cross."""
    for one, other in combinations(sets, 2):
        for start, run, start2, run2 in (
            (one.a, one.b - one.a, other.a, other.b - other.a),
            (one.d, one.c - one.d, other.d, other.c - other.d),
        ):
            if not math.isclose(run, run2):
                yield (start2 - start) / (run - run2)

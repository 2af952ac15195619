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

import numpy as np
from numpy.typing import NDArray

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


class MamdaniSystem:
    """A fuzzy rule base over named inputs and outputs.

    inputs, outputs: variables; the sets of an output must be finite. rules: any number, each
    naming any inputs and outputs. Raises KeyError for a rule with an unknown name.
    """

    def __init__(
        self, inputs: Sequence[Variable], outputs: Sequence[Variable], rules: Sequence[Rule]
    ) -> None:
        self.inputs, self.outputs, self.rules = tuple(inputs), tuple(outputs), tuple(rules)
        self._input_sets = [(v.name, tuple(v.sets.values())) for v in inputs]
        self._rule_sets = _index_antecedents(self.inputs, self.rules)
        self._firing_rules = _index_consequents(self.outputs, self.rules)
        self._centroid = _Centroid(self.outputs)
        self._last: tuple[list[float], Mapping[str, float]] = [], {}

    def evaluate(self, values: Mapping[str, float]) -> Mapping[str, float]:
        """Return the centroid of every output, for a value of every input (may be infinite).

        An output about which no rule says anything is 0. While no degree changes (a robot alone
        on its border) the very same mapping is returned.
        """
        degrees = [s(values[name]) for name, sets in self._input_sets for s in sets]
        if degrees != self._last[0]:
            centroids = self._centroid.of(self._set_strengths(self._rule_strengths(degrees)))
            levels = dict(zip((v.name for v in self.outputs), centroids.tolist(), strict=True))
            self._last = degrees, MappingProxyType(levels)
        return self._last[1]

    def _rule_strengths(self, degrees: Sequence[float]) -> NDArray[np.float64]:
        """Degree (rules + 1,) to which each rule holds; the last is 0, the rule of the unsaid."""
        degrees = [*degrees, 1.0, 0.0]
        return np.array(degrees)[self._rule_sets].min(axis=1)  # type: ignore[no-any-return]

    def _set_strengths(self, rules: NDArray[np.float64]) -> NDArray[np.float64]:
        """Greatest degree (output sets,) of the rules that name each output set."""
        return rules[self._firing_rules].max(axis=1)  # type: ignore[no-any-return]


def _index_antecedents(inputs: Sequence[Variable], rules: Sequence[Rule]) -> NDArray[np.intp]:
    """Indices (rules + 1, widest rule) into the degrees, filled up with the degree 1."""
    index = {key: i for i, key in enumerate((v.name, name) for v in inputs for name in v.sets)}
    always, never = len(index), len(index) + 1
    rows = [[index[key] for key in rule.when] for rule in rules] + [[never]]
    return _filled(rows, always)


def _index_consequents(outputs: Sequence[Variable], rules: Sequence[Rule]) -> NDArray[np.intp]:
    """Indices (output sets, most rules) into the rules, filled up with the rule that is 0."""
    firing: dict[tuple[str, str], list[int]] = {(v.name, n): [] for v in outputs for n in v.sets}
    for i, rule in enumerate(rules):
        for key in rule.then:
            firing[key].append(i)
    return _filled(list(firing.values()), len(rules))


def _filled(rows: Sequence[Sequence[int]], filler: int) -> NDArray[np.intp]:
    width = max((len(row) for row in rows), default=0)
    return np.array([[*row, *[filler] * (width - len(row))] for row in rows], dtype=np.intp)


class _Centroid:
    """Centroids of many outputs at once from the strengths of their sets.

    Area under max_i min(s_i, mu_i) = sum over groups of sets of (-1)^(size + 1) times the area
    under min over the group of mu_i, cut at min over the group of s_i. Such an overlap is a stack
    of layers between heights h0 and h1 whose ends move linearly with the height.
    """

    def __init__(self, outputs: Sequence[Variable]) -> None:
        groups: list[list[int]] = []
        layers: list[tuple[float, float, float, float, float, float]] = []
        places: list[tuple[int, float]] = []  # output, sign
        first = 0
        for output, variable in enumerate(outputs):
            sets = list(variable.sets.values())
            for group in _groups(len(sets)):
                for layer in _layers([sets[i] for i in group]):
                    groups.append([first + i for i in group])
                    layers.append(layer)
                    places.append((output, 1.0 if len(group) % 2 else -1.0))
            first += len(sets)
        self._groups = _filled_with_own(groups)
        h0, h1, left, left_slope, right, right_slope = np.array(layers).T
        self._bottom, self._height = h0, h1 - h0
        # width(h) = right - left + (right_slope - left_slope) h, and the same for the moment
        # (right(h)^2 - left(h)^2) / 2, integrated over the height from 0 to h
        self._linear = np.array([right - left, (right**2 - left**2) / 2.0])
        self._quadratic = (
            np.array([right_slope - left_slope, right * right_slope - left * left_slope]) / 2.0
        )
        self._cubic = np.array([np.zeros(len(layers)), (right_slope**2 - left_slope**2) / 6.0])
        self._signs = np.zeros((len(layers), len(outputs)))
        for layer_index, (output, sign) in enumerate(places):
            self._signs[layer_index, output] = sign

    def of(self, strengths: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the centroids (outputs,) of strengths (output sets,); 0 where all are 0."""
        cut = strengths[self._groups].min(axis=1)
        h = np.minimum(np.maximum(cut - self._bottom, 0.0), self._height)
        linear, quadratic, cubic = self._linear, self._quadratic, self._cubic
        area, moment = (((cubic * h + quadratic) * h + linear) * h) @ self._signs
        centroids: NDArray[np.float64] = np.zeros_like(area)
        np.divide(moment, area, out=centroids, where=area > 0.0)
        return centroids


def _groups(count: int) -> Iterator[tuple[int, ...]]:
    return chain.from_iterable(combinations(range(count), size) for size in range(1, count + 1))


def _filled_with_own(groups: Sequence[Sequence[int]]) -> NDArray[np.intp]:
    width = max(len(group) for group in groups)
    return np.array([[*g, *[g[0]] * (width - len(g))] for g in groups], dtype=np.intp)


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

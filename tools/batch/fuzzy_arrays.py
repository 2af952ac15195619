"""A Mamdani system evaluated for many inputs at once: ``MamdaniSystem`` in arrays."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from robot_agent.patrol.fuzzy import Centroid, MamdaniSystem, Trapezoid
from tools.batch.arrays import Flags, Reals


class FuzzyArrays:
    """The rules of a system whose outputs have equal sets, as those of ``load_rules`` have."""

    def __init__(self, system: MamdaniSystem) -> None:
        self.inputs = [variable.name for variable in system.inputs]
        self._sets = [list(variable.sets.values()) for variable in system.inputs]
        numbers: dict[tuple[str, str], int] = {}
        for variable in system.inputs:
            for name in variable.sets:
                numbers[variable.name, name] = len(numbers)
        # Rules of one conclusion are joined first: their strength is the greatest.
        joined: dict[tuple[tuple[str, str], ...], list[list[int]]] = {}
        for rule in system.rules:
            joined.setdefault(rule.then, []).append([numbers[key] for key in rule.when])
        self._conclusions = list(joined.values())
        levels = list(system.outputs[0].sets)
        self._named_by = [
            [
                [number for number, then in enumerate(joined) if (output.name, level) in then]
                for output in system.outputs
            ]
            for level in levels
        ]
        self._layers = Centroid(tuple(system.outputs[0].sets.values())).layers

    def evaluate(self, values: Sequence[Reals]) -> Reals:
        """Return (outputs, n) centroids for values (n,) of every input, in their order."""
        degrees = [
            _degree(each, value)
            for sets, value in zip(self._sets, values, strict=True)
            for each in sets
        ]
        conclusions = [self._joined(whens, degrees) for whens in self._conclusions]
        n = len(values[0])
        strengths = np.empty((len(self._named_by), len(self._named_by[0]), n))
        for level, outputs in enumerate(self._named_by):
            for output, named in enumerate(outputs):
                strengths[level, output] = _greatest([conclusions[number] for number in named], n)
        return self._centroids(strengths)

    def _joined(self, whens: Sequence[Sequence[int]], degrees: Sequence[Reals]) -> Reals:
        strongest: Reals | None = None
        for when in whens:
            strength = degrees[when[0]]
            for number in when[1:]:
                strength = np.minimum(strength, degrees[number])
            strongest = strength if strongest is None else np.maximum(strongest, strength)
        assert strongest is not None
        return strongest

    def _centroids(self, strengths: Reals) -> Reals:
        """Return (outputs, n) the centroids of strengths (levels, outputs, n)."""
        area = np.zeros(strengths.shape[1:])
        moment = np.zeros(strengths.shape[1:])
        for first, others, bottom, height, integrals in self._layers:
            h = strengths[first]
            for other in others:
                h = np.minimum(h, strengths[other])
            h = np.minimum(np.maximum(h - bottom, 0.0), height)
            area1, area2, moment1, moment2, moment3 = integrals
            area += h * (area1 + h * area2)
            moment += h * (moment1 + h * (moment2 + h * moment3))
        return np.asarray(np.divide(moment, area, out=np.zeros_like(area), where=area > 0.0))

    def corners(self, name: str) -> list[float]:
        """Return the finite positive values between which the degrees of an input change."""
        (sets,) = (each for key, each in zip(self.inputs, self._sets, strict=True) if key == name)
        points = {x for each in sets for x in (each.a, each.b, each.c, each.d)}
        return sorted(x for x in points if 0.0 < x < math.inf)


def _degree(fuzzy_set: Trapezoid, x: Reals) -> Reals:
    """Return (n,) the degrees to which values (n,) belong to a set."""
    a, b, c, d = fuzzy_set.a, fuzzy_set.b, fuzzy_set.c, fuzzy_set.d
    degree: Reals | None = None
    if math.isfinite(a) and (b > a or x.min(initial=math.inf) < a):
        degree = (x - a) / (b - a) if b > a else _real(x >= a)
    if math.isfinite(d):
        falling = (d - x) / (d - c) if d > c else _real(x <= d)
        degree = falling if degree is None else np.minimum(degree, falling)
    if degree is None:
        return np.ones(len(x))
    return np.asarray(np.minimum(np.maximum(degree, 0.0), 1.0))


def _real(flags: Flags) -> Reals:
    return flags.astype(np.float64)


def _greatest(strengths: Sequence[Reals], n: int) -> Reals:
    if not strengths:
        return np.zeros(n)
    greatest = strengths[0]
    for strength in strengths[1:]:
        greatest = np.maximum(greatest, strength)
    return greatest

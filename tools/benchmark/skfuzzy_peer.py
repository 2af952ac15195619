"""Builds a fuzzy system a second time with skfuzzy.control, for comparison and timing."""

from __future__ import annotations

from typing import Any

import numpy as np
import skfuzzy
from numpy.typing import NDArray
from skfuzzy import control

from robot_agent.patrol.fuzzy import MamdaniSystem, Trapezoid

FARTHEST = 4.0
"""m; stands for infinity in skfuzzy's finite universes."""


def finite(fuzzy_set: Trapezoid) -> list[float]:
    """Return a set's four break points, m, none beyond ``FARTHEST``."""
    return [min(x, FARTHEST) for x in (fuzzy_set.a, fuzzy_set.b, fuzzy_set.c, fuzzy_set.d)]


def simulation_of(system: MamdaniSystem, output_universe: NDArray[np.float64]) -> Any:
    """Return skfuzzy's ControlSystemSimulation of a system's rule base.

    output_universe: (n,) ascending, the points between which skfuzzy integrates.
    """
    terms = _antecedents(system) | _consequents(system, output_universe)
    rules = []
    for rule in system.rules:
        condition = terms[rule.when[0]]
        for key in rule.when[1:]:
            condition = condition & terms[key]
        rules.append(control.Rule(condition, [terms[key] for key in rule.then]))
    return control.ControlSystemSimulation(control.ControlSystem(rules))


def _antecedents(system: MamdaniSystem) -> dict[tuple[str, str], Any]:
    terms = {}
    for variable in system.inputs:
        corners = sorted({x for s in variable.sets.values() for x in finite(s)})
        antecedent = control.Antecedent(np.array(corners), variable.name)
        for name, fuzzy_set in variable.sets.items():
            antecedent[name] = skfuzzy.trapmf(antecedent.universe, finite(fuzzy_set))
            terms[variable.name, name] = antecedent[name]
    return terms


def _consequents(
    system: MamdaniSystem, universe: NDArray[np.float64]
) -> dict[tuple[str, str], Any]:
    """Return the output sets that rules name; skfuzzy fails for an array if one is never named."""
    named = {key for rule in system.rules for key in rule.then}
    terms = {}
    for variable in system.outputs:
        consequent = control.Consequent(universe, variable.name, "centroid")
        for name, fuzzy_set in variable.sets.items():
            if (variable.name, name) in named:
                consequent[name] = skfuzzy.trapmf(consequent.universe, finite(fuzzy_set))
                terms[variable.name, name] = consequent[name]
    return terms

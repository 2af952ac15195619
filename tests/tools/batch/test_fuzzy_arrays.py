"""The rules evaluated for many inputs equal those evaluated for each."""

import numpy as np
import pytest

from robot_agent.patrol.rules import RULES_FILE, load_rules
from tools.batch.fuzzy_arrays import FuzzyArrays


@pytest.mark.parametrize("open_border", [False, True])
@pytest.mark.parametrize("reading", ["R1", "R2", "R3"])
def test_degrees_are_those_of_the_mamdani_system(reading, open_border):
    system = load_rules(RULES_FILE, reading=reading, safety_distance=2.4, open_border=open_border)
    rng = np.random.default_rng(1)
    values = [rng.uniform(-1.0 if "state" in v.name else 0.0, 3.0, 500) for v in system.inputs]
    values[2] = np.clip(values[2], -1.0, 1.0)
    values[1][::4] = np.inf
    degrees = FuzzyArrays(system).evaluate(values)
    for index in range(500):
        inputs = {v.name: float(x[index]) for v, x in zip(system.inputs, values, strict=True)}
        assert degrees[:, index].tolist() == list(system.evaluate(inputs).values())

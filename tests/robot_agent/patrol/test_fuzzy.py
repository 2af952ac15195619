"""The exact Mamdani evaluation against skfuzzy, and its generic properties."""

import math
import subprocess
import sys

import numpy as np
import pytest
import skfuzzy
from hypothesis import given, settings
from hypothesis import strategies as st

from robot_agent.patrol.fuzzy import MamdaniSystem, Rule, Trapezoid, Variable
from robot_agent.patrol.rules import RULES_FILE, load_rules
from tools.benchmark.skfuzzy_peer import FARTHEST, finite, simulation_of


def shipped(*, open_border: bool = False) -> MamdaniSystem:
    return load_rules(RULES_FILE, reading="R1", safety_distance=2.4, open_border=open_border)


def round_values(variable: Variable, step: float = 0.05) -> list[float]:
    """Values at which the degrees of all sets are multiples of a step."""
    corners = [finite(fuzzy_set) for fuzzy_set in variable.sets.values()]
    edges = [edge for a, b, c, d in corners for edge in ((a, b), (c, d))]
    shares = np.arange(0.0, 1.0 + step / 2.0, step)
    values = sorted({round(a + share * (b - a), 12) for a, b in edges for share in shares})
    degrees = np.array([[s(x) for s in variable.sets.values()] for x in values]) / step
    return np.array(values)[(np.abs(degrees - np.rint(degrees)) < 1e-9).all(axis=1)].tolist()


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
@pytest.mark.parametrize(
    ("stride", "points"), [(6, 500), pytest.param(2, 10_000, marks=pytest.mark.long)]
)
@pytest.mark.parametrize("reading", ["R1", "R2", "R3"])
def test_equals_skfuzzy_control_on_a_grid(reading, stride, points):
    """skfuzzy integrates between the points of its output universe and the points where each
    set is cut at its own strength; it misses where one set rises out of another's plateau. With
    strengths that are multiples of 0.05 all those points are multiples of 0.025."""
    system = load_rules(RULES_FILE, reading=reading, safety_distance=2.4, open_border=False)
    axes = [round_values(variable)[::stride] for variable in system.inputs]
    grid = np.array(np.meshgrid(*axes)).reshape(len(axes), -1)
    assert grid.shape[1] >= points
    simulation = simulation_of(system, np.linspace(0.0, 1.0, 41))
    names = [variable.name for variable in system.inputs]
    for name, column in zip(names, grid, strict=True):
        simulation.input[name] = column
    simulation.compute()
    ours = [system.evaluate(dict(zip(names, point, strict=True))) for point in grid.T.tolist()]
    for output, levels in simulation.output.items():
        assert [each[output] for each in ours] == pytest.approx(levels, abs=1e-9), output


def sampled_centroid(system: MamdaniSystem, values: dict[str, float]) -> dict[str, float]:
    """skfuzzy's membership functions and centroid, on a universe with every break point."""
    degrees = {
        (v.name, name): float(
            skfuzzy.trapmf(np.array([min(values[v.name], FARTHEST)]), finite(s))[0]
        )
        for v in system.inputs
        for name, s in v.sets.items()
    }
    strengths = [min(degrees[key] for key in rule.when) for rule in system.rules]
    result = {}
    for output in system.outputs:
        fired = list(zip(strengths, system.rules, strict=True))
        cuts = {
            name: max((f for f, rule in fired if (output.name, name) in rule.then), default=0.0)
            for name in output.sets
        }
        universe = {x for s in output.sets.values() for x in (s.a, s.b, s.c, s.d)}
        for s in output.sets.values():
            for cut in cuts.values():
                universe |= {s.a + cut * (s.b - s.a), s.d - cut * (s.d - s.c)}
            for other in output.sets.values():
                slope = (s.b - s.a) + (other.d - other.c)
                universe.add(s.a + (other.d - s.a) / slope * (s.b - s.a) if slope else s.a)
        z = np.array(sorted(x for x in universe if 0.0 <= x <= 1.0))
        level = np.zeros_like(z)
        for name, s in output.sets.items():
            level = np.maximum(level, np.minimum(cuts[name], skfuzzy.trapmf(z, finite(s))))
        result[output.name] = skfuzzy.defuzz(z, level, "centroid")
    return result


@pytest.mark.parametrize("open_border", [False, True])
def test_equals_skfuzzy_functions_at_random_points(open_border):
    system = shipped(open_border=open_border)
    rng = np.random.default_rng(5)
    for _ in range(300):
        values = {
            "distance_from_border": rng.uniform(0.0, 2.5),
            "distance_from_neighbor": rng.uniform(0.0, 3.0),
            "neighbor_state": rng.uniform(-1.0, 1.0),
            "distance_from_left_end": rng.uniform(0.0, 1.2),
            "distance_from_right_end": rng.uniform(0.0, 1.2),
        }
        theirs = sampled_centroid(system, values)
        ours = system.evaluate(values)
        assert ours == pytest.approx(theirs, abs=1e-9), values


def test_evaluates_a_rule_base_of_another_domain():
    service = Variable("service", {"poor": Trapezoid(0, 0, 2, 5), "good": Trapezoid(3, 8, 10, 10)})
    tip = Variable("tip", {"small": Trapezoid(0, 0, 5, 15), "large": Trapezoid(5, 18, 18, 25)})
    system = MamdaniSystem(
        [service],
        [tip],
        [
            Rule((("service", "poor"),), (("tip", "small"),)),
            Rule((("service", "good"),), (("tip", "large"),)),
        ],
    )
    assert system.evaluate({"service": 4.0})["tip"] == pytest.approx(
        sampled_over(tip, {"small": 1 / 3, "large": 0.2}), abs=1e-3
    )
    assert system.evaluate({"service": 0.0})["tip"] == pytest.approx(
        (12.5 + 5.0 * (5.0 + 10.0 / 3.0)) / 10.0
    )


def sampled_over(output: Variable, cuts: dict[str, float]) -> float:
    z = np.linspace(0.0, 25.0, 200_001)
    level = np.zeros_like(z)
    for name, s in output.sets.items():
        level = np.maximum(level, np.minimum(cuts[name], [s(x) for x in z]))
    return float((z * level).sum() / level.sum())


ascending = st.lists(st.integers(0, 20), min_size=4, max_size=4).map(sorted)


@settings(max_examples=60)
@given(st.lists(ascending, min_size=1, max_size=4), st.data())
def test_centroid_of_any_sets_equals_a_dense_sampling(corners, data):
    """Three and more sets over one point, vertical edges, gaps: as a dense sampling has it."""
    sets = {str(i): Trapezoid(*map(float, c)) for i, c in enumerate(corners)}
    cuts = {name: data.draw(st.floats(0.05, 1.0)) for name in sets}
    if not any(s.d > s.a for s in sets.values()):
        return
    inputs = [Variable(name, {"on": Trapezoid(0.0, 1.0, 1.0, 1.0)}) for name in sets]
    rules = [Rule(((name, "on"),), (("out", name),)) for name in sets]
    system = MamdaniSystem(inputs, [Variable("out", sets)], rules)
    step = 0.001
    z = np.arange(step / 2, 20.0, step)
    level = np.zeros_like(z)
    for name, s in sets.items():
        edges = np.interp(z, [s.a, s.b, s.c, s.d], [0, 1, 1, 0])
        inside = (z > s.a) & (z < s.d)
        level = np.maximum(level, np.minimum(cuts[name], edges * inside))
    sampled = (z * level).sum() / level.sum()
    assert system.evaluate(cuts)["out"] == pytest.approx(sampled, abs=2e-3)


def test_output_without_an_active_rule_is_zero():
    x = Variable("x", {"low": Trapezoid(0, 0, 1, 1), "high": Trapezoid(2, 2, 3, 3)})
    system = MamdaniSystem([x], [x], [Rule((("x", "low"),), (("x", "high"),))])
    assert system.evaluate({"x": 1.0})["x"] == pytest.approx(2.5)
    assert system.evaluate({"x": 1.5})["x"] == 0.0


def test_unknown_names_in_rules_raise():
    x = Variable("x", {"low": Trapezoid(0, 0, 1, 1)})
    with pytest.raises(KeyError):
        MamdaniSystem([x], [x], [Rule((("x", "high"),), (("x", "low"),))])
    with pytest.raises(KeyError):
        MamdaniSystem([x], [x], [Rule((("x", "low"),), (("y", "low"),))])


@pytest.mark.parametrize(
    ("x", "degree"),
    [(-1.0, 0.0), (0.0, 1.0), (0.4, 1.0), (0.7, 0.5), (1.0, 0.0), (math.inf, 0.0)],
)
def test_left_shoulder(x, degree):
    assert Trapezoid(0.0, 0.0, 0.4, 1.0)(x) == pytest.approx(degree)


@pytest.mark.parametrize(("x", "degree"), [(1.0, 0.0), (1.5, 0.5), (2.0, 1.0), (math.inf, 1.0)])
def test_right_shoulder_reaches_infinity(x, degree):
    assert Trapezoid(1.0, 2.0, math.inf, math.inf)(x) == pytest.approx(degree)


def test_trapezoid_with_descending_points_raises():
    with pytest.raises(ValueError, match="do not ascend"):
        Trapezoid(0.0, 2.0, 1.0, 3.0)


def test_agent_does_not_import_skfuzzy_control():
    code = (
        "import sys, robot_agent.patrol.patrol, robot_agent.motion.gate,"
        " robot_agent.motion.heading_loop;"
        "print([m for m in ('skfuzzy.control', 'matplotlib', 'networkx') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"

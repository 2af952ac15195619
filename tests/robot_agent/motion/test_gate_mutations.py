"""A share of the gate's mutants must break its cases; `patrol mutation` runs them all."""

import ast

from tools.quality.gate_mutation import SURVIVORS, judge, load_cases, mutant_names, unexplained
from tools.quality.mutation import mutants

EVERY = 12


def test_every_mutant_of_a_share_is_killed_or_explained():
    verdicts = list(judge(load_cases(), EVERY, first=5))
    assert len(verdicts) >= 25
    assert unexplained([verdict.mutant for verdict in verdicts if not verdict.killed]) == []


def test_known_survivors_are_mutants():
    names = mutant_names()
    for name, _ in SURVIVORS:
        assert name in names


def test_mutants_change_comparisons_constants_signs_and_operators():
    tree = ast.parse("def f(a: float = 2.0) -> bool:\n    return -a + 1 < 3.0 and a is not None")
    before = ast.unparse(tree)
    names = list(mutants(tree))
    assert ast.unparse(tree) == before, "every mutation must have been undone"
    assert sorted(names) == sorted(
        [
            "f: 2.0 -> 2.2",
            "f: 2.0 -> 1.8",
            "f: -a + 1 < 3.0 and a is not None -> -a + 1 < 3.0 or a is not None",
            "f: a is not None -> a is None",
            "f: -a + 1 < 3.0 -> -a + 1 <= 3.0",
            "f: -a + 1 < 3.0 -> -a + 1 >= 3.0",
            "f: -a + 1 -> -a - 1",
            "f: 3.0 -> 3.3000000000000003",
            "f: 3.0 -> 2.7",
            "f: -a -> a",
            "f: 1 -> 2",
            "f: 1 -> 0",
        ]
    )

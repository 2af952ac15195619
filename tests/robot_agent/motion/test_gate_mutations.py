"""Mutation test of the gate: every comparison and constant changed must break a case of the table.

Each mutant of gate.py's syntax tree is run in this process on the cases of test_gate.py until one
of them fails. Mutants that no case can tell from the original are listed with the reason.
"""

import ast
import copy
import importlib.util
import inspect
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest

from robot_agent.motion import gate

TREE = ast.parse(inspect.getsource(gate))

NEGATED = {
    ast.Lt: (ast.LtE, ast.GtE),
    ast.LtE: (ast.Lt, ast.Gt),
    ast.Gt: (ast.GtE, ast.LtE),
    ast.GtE: (ast.Gt, ast.Lt),
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
    ast.Is: (ast.IsNot,),
    ast.IsNot: (ast.Is,),
    ast.In: (ast.NotIn,),
}

LEFT_OUT = ("annotation", "returns", "decorator_list", "keywords", "bases")

ONE_POINT = "differs only for a point exactly on an edge, which rounding decides"
SAME = "no difference: "
SURVIVORS = [
    ("_free_share: x < front -> x <= front", ONE_POINT),
    ("_free_share: x > -rear -> x >= -rear", ONE_POINT),
    (
        "_free_share: np.abs(obstacles).max(axis=1, initial=0.0) < reach -> "
        "np.abs(obstacles).max(axis=1, initial=0.0) <= reach",
        SAME + "the reach is longer than anything the body can sweep",
    ),
    ("_free_share: 0.0 -> -1.0", SAME + "start of a maximum of magnitudes"),
    (
        "_within_speed: abs(w) > turn_limit -> abs(w) >= turn_limit",
        SAME + "the share is 1 at the limit",
    ),
    ("_within_speed: v > limit -> v >= limit", SAME + "the share is 1 at the limit"),
    ("_within_speed: 1.0 -> 2.0", SAME + "the minimum takes the other share, at most 1"),
    ("_within_speed: 1.0 -> 2.0", SAME + "the minimum takes the other share, at most 1"),
]


def _table() -> ModuleType:
    """The module of the case table, test_gate.py beside this file."""
    path = Path(__file__).with_name("test_gate.py")
    spec = importlib.util.spec_from_file_location("gate_case_table", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


SWAPPED = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.BitAnd: ast.BitOr,
}


def _mutations(node: ast.AST) -> Iterator[tuple[str, ast.AST]]:
    """Changed copies of one node, each with its name: source before -> source after."""
    if isinstance(node, ast.Compare):
        changed = _other_comparisons(node)
    elif isinstance(node, ast.Constant):
        changed = _other_constants(node.value)
    elif isinstance(node, ast.UnaryOp):
        changed = [node.operand]
    elif isinstance(node, ast.BinOp) and type(node.op) in SWAPPED:
        changed = [ast.BinOp(node.left, SWAPPED[type(node.op)](), node.right)]
    elif isinstance(node, ast.BoolOp):
        changed = [ast.BoolOp(ast.Or() if isinstance(node.op, ast.And) else ast.And(), node.values)]
    else:
        changed = []
    for mutant in changed:
        yield f"{ast.unparse(node)} -> {ast.unparse(mutant)}", mutant


def _other_comparisons(node: ast.Compare) -> list[ast.AST]:
    changed: list[ast.AST] = []
    for i, operator in enumerate(node.ops):
        for other in NEGATED[type(operator)]:
            mutant = copy.deepcopy(node)
            mutant.ops[i] = other()
            changed.append(mutant)
    return changed


def _other_constants(value: object) -> list[ast.AST]:
    if isinstance(value, bool):
        return [ast.Constant(not value)]
    if not isinstance(value, int | float):
        return []
    if value in (0, 1):
        return [ast.Constant(type(value)(value + 1)), ast.Constant(type(value)(value - 1))]
    return [ast.Constant(value * 1.1), ast.Constant(value * 0.9)]


def _code_nodes() -> Iterator[tuple[str, ast.AST, str, int | None, ast.AST]]:
    """(name, parent, field, index, node) of every node of the code proper.

    Annotations, imports and the names of the reasons are left out.
    """
    stack: list[tuple[str, ast.AST]] = [("", TREE)]
    while stack:
        name, parent = stack.pop()
        if isinstance(parent, ast.FunctionDef | ast.ClassDef):
            name = parent.name
        for attribute, value in ast.iter_fields(parent):
            if attribute in LEFT_OUT and not isinstance(parent, ast.Call):
                continue
            for index, child in enumerate(value) if isinstance(value, list) else [(None, value)]:
                if isinstance(child, ast.AST) and not isinstance(child, ast.ImportFrom):
                    if isinstance(child, ast.Assign) and "Annotated" in ast.unparse(child):
                        continue
                    yield name, parent, attribute, index, child
                    stack.append((name, child))


def _mutants() -> Iterator[str]:
    """Mutate TREE in place, one change at a time, and undo it; yields the name of each."""
    for name, parent, attribute, index, node in list(_code_nodes()):
        for text, mutant in _mutations(node):
            if isinstance(parent, ast.AnnAssign):
                text = f"{ast.unparse(parent.target)} = {text}"
            original = getattr(parent, attribute)
            if index is None:
                setattr(parent, attribute, mutant)
            else:
                original[index] = mutant
            ast.fix_missing_locations(TREE)
            yield f"{name}: {text}"
            if index is None:
                setattr(parent, attribute, original)
            else:
                original[index] = node


def _load(tree: ast.Module) -> ModuleType:
    module = ModuleType("gate_mutant")
    sys.modules["gate_mutant"] = module  # dataclasses look their module up
    exec(compile(tree, "gate_mutant", "exec"), module.__dict__)
    return module


def _killed(table: ModuleType) -> bool:
    """Tell whether some case fails on TREE as it is now."""
    try:
        module = _load(TREE)
        return not all(table.fits(case, table.run(case, module)) for case in table.CASES)
    except Exception:  # noqa: BLE001 - a mutant that fails to run is dead too
        return True


@pytest.mark.filterwarnings("ignore")
def test_every_mutant_is_killed():
    table = _table()
    assert not _killed(table), "the table must hold for the original"
    verdicts = [(name, _killed(table)) for name in _mutants()]
    assert not _killed(table), "every mutation must have been undone"
    assert len(verdicts) > 150
    assert sorted(name for name, killed in verdicts if not killed) == sorted(
        name for name, _ in SURVIVORS
    )

"""Generates mutants of source code: one comparison, constant, sign or operator changed each."""

from __future__ import annotations

import ast
import copy
from collections.abc import Iterator

_OTHER_COMPARISONS: dict[type[ast.cmpop], tuple[type[ast.cmpop], ...]] = {
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
_OTHER_OPERATORS: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
}
_INERT_PARTS = ("annotation", "returns", "decorator_list", "keywords", "bases")
"""Parts of a definition that do not affect behaviour."""


def mutants(tree: ast.Module) -> Iterator[str]:
    """Mutate a tree in place; each change is undone before the next.

    Yields each mutant's name: place, source before -> source after. Annotations, imports and
    type aliases are not mutated.
    """
    for place, parent, attribute, index, node in list(_code_nodes(tree)):
        for text, mutant in _mutations(node):
            if isinstance(parent, ast.AnnAssign):
                text = f"{ast.unparse(parent.target)} = {text}"
            _put(parent, attribute, index, mutant)
            ast.fix_missing_locations(tree)
            yield f"{place}: {text}" if place else text
            _put(parent, attribute, index, node)


def _put(parent: ast.AST, attribute: str, index: int | None, node: ast.AST) -> None:
    if index is None:
        setattr(parent, attribute, node)
    else:
        getattr(parent, attribute)[index] = node


def _code_nodes(tree: ast.Module) -> Iterator[tuple[str, ast.AST, str, int | None, ast.AST]]:
    """Yield (place, parent, attribute, index, node) of every node that may be mutated."""
    stack: list[tuple[str, ast.AST]] = [("", tree)]
    while stack:
        place, parent = stack.pop()
        if isinstance(parent, ast.FunctionDef | ast.ClassDef):
            place = parent.name
        for attribute, value in ast.iter_fields(parent):
            if attribute in _INERT_PARTS and not isinstance(parent, ast.Call):
                continue
            children = enumerate(value) if isinstance(value, list) else [(None, value)]
            for index, child in children:
                if isinstance(child, ast.AST) and not _is_inert(child):
                    yield place, parent, attribute, index, child
                    stack.append((place, child))


def _is_inert(node: ast.AST) -> bool:
    is_alias = isinstance(node, ast.Assign) and "Annotated" in ast.unparse(node)
    return is_alias or isinstance(node, ast.Import | ast.ImportFrom)


def _mutations(node: ast.AST) -> Iterator[tuple[str, ast.AST]]:
    """Yield name and changed copy of one node, for each mutation."""
    changed: list[ast.AST] = []
    if isinstance(node, ast.Compare):
        changed = _other_comparisons(node)
    elif isinstance(node, ast.Constant):
        changed = _other_constants(node.value)
    elif isinstance(node, ast.UnaryOp):
        changed = [node.operand]
    elif isinstance(node, ast.BinOp) and type(node.op) in _OTHER_OPERATORS:
        changed = [ast.BinOp(node.left, _OTHER_OPERATORS[type(node.op)](), node.right)]
    elif isinstance(node, ast.BoolOp):
        changed = [ast.BoolOp(ast.Or() if isinstance(node.op, ast.And) else ast.And(), node.values)]
    for mutant in changed:
        yield f"{ast.unparse(node)} -> {ast.unparse(mutant)}", mutant


def _other_comparisons(node: ast.Compare) -> list[ast.AST]:
    changed: list[ast.AST] = []
    for place, operator in enumerate(node.ops):
        for other in _OTHER_COMPARISONS[type(operator)]:
            mutant = copy.deepcopy(node)
            mutant.ops[place] = other()
            changed.append(mutant)
    return changed


def _other_constants(value: object) -> list[ast.AST]:
    if isinstance(value, bool):
        return [ast.Constant(not value)]
    if isinstance(value, int):
        return [ast.Constant(value + 1), ast.Constant(value - 1)]
    if not isinstance(value, float):
        return []
    if value in (0.0, 1.0):
        return [ast.Constant(value + 1.0), ast.Constant(value - 1.0)]
    return [ast.Constant(value * 1.1), ast.Constant(value * 0.9)]

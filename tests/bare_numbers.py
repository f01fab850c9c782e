"""Numbers in the code of a room: module constants, and numbers that are compared with."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

from tests.imports import parsed

ROUNDING = 1e-6
"""Smaller numbers only keep a division or a comparison from failing."""


def constants(path: Path) -> set[str]:
    """Return names of module constants that hold a number."""
    made = [node for node in parsed(path).body if isinstance(node, ast.Assign) and any(_numbers(node.value))]
    names = (name for node in made for target in node.targets for name in ast.walk(target))
    return {name.id for name in names if isinstance(name, ast.Name)}


def compared(path: Path) -> set[float]:
    """Return numbers above rounding that stand in a comparison, outside calls and subscripts."""
    sides = (
        side
        for node in ast.walk(parsed(path))
        if isinstance(node, ast.Compare)
        for side in (node.left, *node.comparators)
        if not isinstance(side, ast.Call | ast.Subscript)
    )
    return {number for side in sides for number in _numbers(side) if number > ROUNDING}


def _numbers(node: ast.AST) -> Iterator[float]:
    for part in ast.walk(node):
        if isinstance(part, ast.Constant) and isinstance(part.value, int | float) and not isinstance(part.value, bool):
            yield part.value

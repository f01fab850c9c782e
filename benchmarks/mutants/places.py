"""What stands at a line of a source: its statement, whether a call runs it, by which names others reach it."""

from __future__ import annotations

import ast
import re
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

KERNEL = re.compile(r"njit|kernel|cfunc")
Function = ast.FunctionDef | ast.AsyncFunctionDef
Scope = ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef


@dataclass(frozen=True)
class Place:
    """Of a line.

    lines    of its innermost statement, of the head alone where others stand below it
    called   in the body of a function, so that calls run it; all else runs once, when the file is imported
    kernel   in the body of a function that is compiled
    names    by which others reach it: its functions' names; outside of them, what it defines and the class it is in
    around   where it is not called: the lines of the function (it is a default) or the class that it belongs to
    """

    lines: range
    called: bool
    kernel: bool
    names: frozenset[str]
    around: range


class Source:
    """A parsed file."""

    def __init__(self, text: str) -> None:
        self.tree = ast.parse(text)

    def place(self, line: int) -> Place:
        """What stands at a line."""
        statements = [node for node in ast.walk(self.tree) if isinstance(node, ast.stmt) and line in _lines(node)]
        functions = [node for node in statements if isinstance(node, Function) and line >= node.body[0].lineno]
        if functions:
            names = frozenset(function.name for function in functions)
            return Place(_head(statements[-1]), True, any(map(is_kernel, functions)), names, range(0))
        return _imported(statements)

    @cached_property
    def has_kernels(self) -> bool:
        """Whether numba compiles a function of it."""
        return any(map(is_kernel, ast.walk(self.tree)))

    @cached_property
    def uses(self) -> dict[str, list[int]]:
        """Lines by the name, or attribute, that they use."""
        lines = defaultdict(list)
        for node in ast.walk(self.tree):
            if isinstance(node, ast.Name) and not _is_defined(node):
                lines[node.id].append(node.lineno)
            elif isinstance(node, ast.Attribute):
                lines[node.attr].append(node.lineno)
        return lines


def is_kernel(node: ast.AST) -> bool:
    """Whether numba compiles a function, by its decorators."""
    return isinstance(node, Function) and any(KERNEL.search(ast.unparse(one)) for one in node.decorator_list)


def _imported(statements: Sequence[ast.stmt]) -> Place:
    """What runs once, by the statements around it."""
    scopes = [node for node in statements if isinstance(node, Scope)]
    given = {node.id for node in ast.walk(statements[-1]) if isinstance(node, ast.Name) and _is_defined(node)}
    around = _lines(scopes[-1]) if scopes else range(0)
    return Place(_head(statements[-1]), False, False, frozenset(given | {scope.name for scope in scopes}), around)


def _is_defined(name: ast.Name) -> bool:
    return isinstance(name.ctx, ast.Store)


def _lines(node: ast.stmt) -> range:
    first = min([node.lineno, *(one.lineno for one in getattr(node, "decorator_list", ()))])
    return range(first, (node.end_lineno or node.lineno) + 1)


def _head(node: ast.stmt) -> range:
    """The lines of a statement that are not those of others below it."""
    lines = _lines(node)
    below = [child.lineno for child in ast.walk(node) if isinstance(child, ast.stmt) and child is not node]
    return range(lines.start, max(min([*below, lines.stop]), lines.start + 1))

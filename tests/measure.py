"""How long and how tangled a function is: tokens without comments and its documentation, and its complexity."""

from __future__ import annotations

import ast
import bisect
import io
import re
import tokenize
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from tests.imports import nodes

SPACE = {
    *(tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE),
    *(tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER),
}
BRANCHES = (ast.If, ast.For, ast.While, ast.ExceptHandler, ast.IfExp, ast.comprehension)
WORD = re.compile(r"\w+|[^\w\s]")
"""A word or a sign, of which every token has one or more."""
COMPILED = ("njit", "kernel", "cfunc")


@dataclass(frozen=True)
class Measured:
    """A function as file.name, with its size in tokens and its complexity (branches and one)."""

    name: str
    tokens: int
    complexity: int


def functions(path: Path, least: int = 0) -> Iterator[Measured]:
    """Every function of a file but numba's kernels; of one with fewer words and signs than `least` no token is counted.

    To take a file apart into tokens takes longer than to parse it, and nearly all functions are short.
    """
    text = path.read_text(encoding="utf-8")
    rows, lines = text.splitlines(), list[int]()
    for node in nodes(path):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and not _is_kernel(node):
            counted = len(WORD.findall("\n".join(rows[node.lineno - 1 : node.end_lineno]))) >= least
            lines = lines or (_lines(text) if counted else [])
            yield Measured(f"{path.stem}.{node.name}", _tokens(node, lines) if counted else 0, _complexity(node))


def _lines(text: str) -> list[int]:
    """The line of every token."""
    tokens = tokenize.generate_tokens(io.StringIO(text).readline)
    return [token.start[0] for token in tokens if token.type not in SPACE]


def complexities(path: Path) -> Iterator[tuple[str, int]]:
    """Name and complexity of every function of a file, kernels too."""
    for node in nodes(path):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            yield f"{path.stem}.{node.name}", _complexity(node)


def _tokens(node: ast.FunctionDef | ast.AsyncFunctionDef, lines: list[int]) -> int:
    def between(first: int, last: int | None) -> int:
        assert last is not None
        return bisect.bisect_right(lines, last) - bisect.bisect_left(lines, first)

    documented = between(node.body[0].lineno, node.body[0].end_lineno) if ast.get_docstring(node) else 0
    return between(node.lineno, node.end_lineno) - documented


def _complexity(node: ast.AST) -> int:
    parts = list(ast.walk(node))
    words = sum(len(part.values) - 1 for part in parts if isinstance(part, ast.BoolOp))
    return 1 + words + sum(isinstance(part, BRANCHES) for part in parts)


def _is_kernel(node: ast.FunctionDef | ast.AsyncFunctionDef) -> bool:
    return any(word in ast.unparse(decorator) for decorator in node.decorator_list for word in COMPILED)

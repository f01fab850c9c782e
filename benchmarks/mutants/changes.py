"""Every mutant of a source file: one operator, comparison, word, sign, number or result made another.

Left out, because no test is meant to notice: `<` made `<=`, numbers of a drawing, annotations, decorators, texts,
what an error says, and `strict=True` of a zip, a check of the program by itself that no input reaches.
"""

from __future__ import annotations

import ast
import itertools
import re
from collections.abc import Iterator
from dataclasses import dataclass

ARITHMETIC: dict[type[ast.operator], tuple[str, str]] = {
    ast.Add: ("+", "-"),
    ast.Sub: ("-", "+"),
    ast.Mult: ("*", "/"),
    ast.Div: ("/", "*"),
    ast.FloorDiv: ("//", "/"),
    ast.Mod: ("%", "*"),
    ast.Pow: ("**", "*"),
    ast.BitAnd: ("&", "|"),
    ast.BitOr: ("|", "&"),
}
COMPARISONS: dict[type[ast.cmpop], tuple[str, str]] = {
    ast.Lt: ("<", ">="),
    ast.LtE: ("<=", ">"),
    ast.Gt: (">", "<="),
    ast.GtE: (">=", "<"),
    ast.Eq: ("==", "!="),
    ast.NotEq: ("!=", "=="),
    ast.Is: ("is", "is not"),
    ast.IsNot: ("is not", "is"),
    ast.In: ("in", "not in"),
    ast.NotIn: ("not in", "in"),
}
WORDS: dict[type[ast.boolop], tuple[str, str]] = {ast.And: ("and", "or"), ast.Or: ("or", "and")}


@dataclass(frozen=True)
class Mutant:
    """`before` at offsets [start, end) of a file's text becomes `after`; line: counted from 1."""

    path: str
    line: int
    start: int
    end: int
    before: str
    after: str
    kind: str

    def key(self, text: str) -> str:
        """What tells it from the others while the file's text changes elsewhere: its line with the mistake marked."""
        first, end = text.rfind("\n", 0, self.start) + 1, text.find("\n", self.end)
        marked = f"{text[first : self.start]}[{self.before} -> {self.after}]{text[self.end : end]}"
        return f"{self.path}: {' '.join(marked.split())}"

    def applied(self, text: str) -> str:
        """The text of the file with the mistake."""
        return text[: self.start] + self.after + text[self.end :]


@dataclass(frozen=True)
class Source:
    """A file's text, with the way from a node's line and column (bytes, as ast counts) to an offset in the text."""

    path: str
    text: str

    def offset(self, line: int, column: int) -> int:
        """Offset in the text of a line, from 1, and a column in bytes."""
        lines = self.text.splitlines(keepends=True)
        return sum(map(len, lines[: line - 1])) + len(lines[line - 1].encode()[:column].decode())

    def span(self, node: ast.expr | ast.stmt) -> tuple[int, int]:
        """Offsets of a node."""
        assert node.end_lineno is not None
        assert node.end_col_offset is not None
        return self.offset(node.lineno, node.col_offset), self.offset(node.end_lineno, node.end_col_offset)

    def replaced(self, node: ast.expr | ast.stmt, after: str, kind: str) -> Mutant:
        """A node's text made another."""
        start, end = self.span(node)
        return Mutant(self.path, node.lineno, start, end, self.text[start:end], after, kind)

    def between(self, left: ast.expr, right: ast.expr, words: tuple[str, str], kind: str) -> Iterator[Mutant]:
        """The operator between two nodes made another; none where the text between them is not clear."""
        first, last = self.span(left)[1], self.span(right)[0]
        found = list(re.finditer(re.escape(words[0]), self.text[first:last]))
        if len(found) == 1:
            start, end = first + found[0].start(), first + found[0].end()
            line = self.text.count("\n", 0, start) + 1
            yield Mutant(self.path, line, start, end, *words, kind)


def mutants(path: str, text: str, *, numbers: bool = True) -> list[Mutant]:
    """All mutants of a file in the order of its text; numbers=False leaves numbers as they are."""
    source = Source(path, text)
    found = [mutant for node in _code(ast.parse(text)) for mutant in _of(node, source)]
    return sorted((m for m in found if numbers or m.kind != "number"), key=lambda m: (m.start, m.after))


def _code(node: ast.AST) -> Iterator[ast.AST]:
    """A node and those below it, without annotations, decorators, texts, what an error says, and zip's strict=True."""
    yield node
    for value in _values(node):
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.AST) and not isinstance(child, ast.Raise | ast.JoinedStr | ast.Assert):
                yield from _code(child)


def _values(node: ast.AST) -> Iterator[object]:
    """What a node holds that is code."""
    for name, value in ast.iter_fields(node):
        if name == "keywords" and isinstance(node, ast.Call) and ast.unparse(node.func) == "zip":
            yield [word for word in value if ast.unparse(word) != "strict=True"]
        elif name not in ("annotation", "returns", "decorator_list"):
            yield value


def _of(node: ast.AST, source: Source) -> Iterator[Mutant]:
    match node:
        case ast.BinOp(left=left, op=op, right=right) if type(op) in ARITHMETIC:
            yield from source.between(left, right, ARITHMETIC[type(op)], "operator")
        case ast.Compare() | ast.BoolOp():
            yield from _of_condition(node, source)
        case ast.UnaryOp(op=ast.Not() | ast.USub(), operand=operand):
            start, end = source.span(operand)
            yield source.replaced(node, source.text[start:end], "sign")
        case ast.Constant(value=bool() | int() | float() as value):
            yield source.replaced(node, _other(value), "truth" if isinstance(value, bool) else "number")
        case ast.Return(value=ast.expr() as value) if not isinstance(value, ast.Constant):
            yield source.replaced(value, "None", "result")


def _of_condition(node: ast.Compare | ast.BoolOp, source: Source) -> Iterator[Mutant]:
    """Each comparison of a chain, each word between two conditions."""
    if isinstance(node, ast.Compare):
        values, words = [node.left, *node.comparators], [COMPARISONS[type(op)] for op in node.ops]
        kind = "comparison"
    else:
        values, words = node.values, [WORDS[type(node.op)]] * (len(node.values) - 1)
        kind = "word"
    for (one, other), change in zip(itertools.pairwise(values), words, strict=True):
        yield from source.between(one, other, change, kind)


def _other(value: bool | int | float) -> str:
    if isinstance(value, bool):
        return str(not value)
    if isinstance(value, int):
        return str(value + 1)
    return repr(2.0 * value if value else 1.0)

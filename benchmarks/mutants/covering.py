"""Which tests cover a source file: its mirror first, then those that import it, then those nearest to it."""

from __future__ import annotations

import ast
from collections import deque
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

FAR = 99


@dataclass(frozen=True)
class Imports:
    """Who imports whom in a tree, by path from its root."""

    of: Mapping[str, frozenset[str]]

    @classmethod
    def read(cls, root: Path, folders: Iterable[str]) -> Imports:
        """The imports that the files of some folders name, those in functions too."""
        paths = [p for folder in folders for p in sorted((root / folder).rglob("*.py"))]
        known = {str(p.relative_to(root)) for p in paths}
        return cls({str(p.relative_to(root)): frozenset(_imported(p, known)) for p in paths})

    def users(self, path: str) -> dict[str, int]:
        """Every file that imports this one, with the number of steps between them."""
        steps, queue = {path: 0}, deque([path])
        while queue:
            here = queue.popleft()
            for user, used in self.of.items():
                if here in used and user not in steps:
                    steps[user] = steps[here] + 1
                    queue.append(user)
        return steps


def _imported(path: Path, known: set[str]) -> Iterable[str]:
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            names = [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
        else:
            continue
        for name in names:
            place = name.replace(".", "/")
            yield from ({f"{place}.py", f"{place}/__init__.py"} & known)


def covering(path: str, imports: Imports, most: int) -> list[str]:
    """The files of tests for a source file, the likeliest first, at most `most` of its own package.

    A mirror is a test file of the same name in the same place below `tests`; after it come those that import the file
    directly or over the fewest steps, and among them those that share the most of its name and of its place.
    """
    steps = imports.users(path)
    package, stem = Path(path).parts[0], Path(path).stem

    def order(test: str) -> tuple[bool, int, int, int, str]:
        inside = Path(test).relative_to("tests")
        mirrored = inside.stem == f"test_{stem}" and inside.parent in Path(path).parents
        words = len(set(stem.split("_")) & set(inside.stem.split("_")))
        return not mirrored, steps.get(test, FAR), -words, -_shared(inside, Path(path)), test

    tests = [p for p in imports.of if Path(p).name.startswith("test_") and p.startswith(f"tests/{package}/")]
    return sorted(tests, key=order)[:most]


def _shared(one: Path, other: Path) -> int:
    """How many folders two places have in common from the left."""
    same = [a == b for a, b in zip(one.parent.parts, other.parent.parts, strict=False)]
    return same.index(False) if False in same else len(same)

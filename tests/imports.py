"""Who imports whom, read from the source, so that imports inside functions count too."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from pathlib import Path, PurePosixPath

from tests.conftest import ROOT

ORDER = ("scenarios", "recordings", "sim", "calib", "validation", "diagnosis", "reports", "papers", "magbench")
FILES = [path for package in ORDER for path in sorted((ROOT / package).rglob("*.py"))]
Graph = Mapping[str, set[str]]


@cache
def parsed(path: Path) -> ast.Module:
    """A file's syntax tree."""
    return ast.parse(path.read_text(encoding="utf-8"))


@cache
def nodes(path: Path) -> tuple[ast.AST, ...]:
    """All nodes of a file's syntax tree."""
    return tuple(ast.walk(parsed(path)))


@cache
def imported(path: Path) -> tuple[str, ...]:
    """Every module that a file names in an import, as `package.module.Name`."""
    return tuple(_imported(path))


def _imported(path: Path) -> Iterator[str]:
    for node in nodes(path):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def name_of(path: Path) -> str:
    """A file by its path from the root."""
    return path.relative_to(ROOT).as_posix()


@cache
def graph() -> Graph:
    """The files that each file imports."""
    known = {name_of(path) for path in FILES}
    return {name_of(path): set(_files(imported(path), known)) - {name_of(path)} for path in FILES}


def _files(modules: Iterable[str], known: set[str]) -> Iterator[str]:
    for module in modules:
        whole, parent = module.replace(".", "/"), module.rpartition(".")[0].replace(".", "/")
        places = (f"{whole}.py", f"{whole}/__init__.py", f"{parent}.py", f"{parent}/__init__.py")
        yield from [place for place in places if place in known][:1]


def rooms(folder: str) -> dict[str, set[str]]:
    """What each file or folder directly in a folder imports of its neighbours there."""
    found: dict[str, set[str]] = {}
    for user, used in graph().items():
        here = _child(user, folder)
        if here is not None:
            neighbours = {_child(name, folder) for name in used} - {None, here}
            found.setdefault(here, set()).update(str(name) for name in neighbours)
    return found


def _child(name: str, folder: str) -> str | None:
    """The file or folder directly in a folder that a file is in or is."""
    parts, above = PurePosixPath(name).parts, PurePosixPath(folder).parts
    return parts[len(above)] if parts[: len(above)] == above and len(parts) > len(above) else None


def circle(edges: Mapping[str, set[str]]) -> list[str]:
    """The names of one circle, or none."""
    left = {name: set(used) for name, used in edges.items()}
    while leaves := [name for name, used in left.items() if not used & left.keys()]:
        for name in leaves:
            del left[name]
    if not left:
        return []
    path = [next(iter(left))]
    while path.count(path[-1]) < 2:
        path.append(sorted(left[path[-1]] & left.keys())[0])
    return path[path.index(path[-1]) :]

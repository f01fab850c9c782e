"""The packages of this repository as one package: `sim/field.py` is imported as `magbench.sim.field`.

A user's project may have a `sim` of its own. setup.py therefore writes nested copies of the packages into a wheel
(`nest`), and an editable installation imports the checkout's own files under the nested names (`NestedFinder`): the
imports are rewritten while a file is compiled, line by line, so that tracebacks, debuggers and coverage show the file
itself and an edit acts at the next start.
"""

from __future__ import annotations

import ast
import os
import sys
from collections.abc import Sequence
from importlib.machinery import ModuleSpec, PathFinder, SourceFileLoader
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any

WHOLE = "magbench"
PARTS = ("scenarios", "recordings", "sim", "calib", "validation", "diagnosis", "reports", "papers")
BYTECODE = ".pyc"
HOOK = '''\
"""Finds magbench in the checkout from which it is installed; PYTEST_DONT_REWRITE, since pytest finds it imported."""

import sys

ROOT = {root!r}


class EditableFinder:
    """Asks the checkout's nesting.py, once, when magbench is imported: every start of Python reads this file alone."""

    @classmethod
    def find_spec(cls, name, path=None, target=None):
        if name != "magbench":
            return None
        sys.meta_path.remove(cls)
        import importlib.util

        spec = importlib.util.spec_from_file_location("_magbench_nesting", ROOT + "/nesting.py")
        nesting = importlib.util.module_from_spec(spec)
        try:
            spec.loader.exec_module(nesting)
        except FileNotFoundError:
            told = ROOT + " has gone, where magbench is installed from: install it anew from where it is now"
            raise ModuleNotFoundError(told + " (pip install -e .)", name=name) from None
        return nesting.find_checkout(ROOT)


sys.meta_path.insert(0, EditableFinder)
'''
"""The module that an editable installation puts in place of the packages."""


def nested(text: str) -> str:
    """Return a module's source with its imports of PARTS as imports of magbench.PART; every line keeps its number.

    Raises ValueError for `import sim.field`, which binds a name that the nested package does not have.
    """
    lines = text.encode().splitlines(keepends=True)
    imports = [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Import | ast.ImportFrom)]
    for node in imports:
        old, new = _heads(node)
        if old:
            line, column = lines[node.lineno - 1], node.col_offset
            assert line[column:].startswith(old)
            lines[node.lineno - 1] = line[:column] + new + line[column + len(old) :]
    return b"".join(lines).decode()


def _heads(node: ast.Import | ast.ImportFrom) -> tuple[bytes, bytes]:
    """The first words of an import of PARTS, plain and nested; empty for an import of anything else."""
    if isinstance(node, ast.ImportFrom):
        return (b"from ", f"from {WHOLE}.".encode()) if _part(node.module or "") else (b"", b"")
    if not any(_part(alias.name) for alias in node.names):
        return b"", b""
    match node.names:
        case [ast.alias(name=str(name))] if "." not in name:
            return b"import ", f"from {WHOLE} import ".encode()
        case [ast.alias(asname=str())]:
            return b"import ", f"import {WHOLE}.".encode()
    raise ValueError(f"line {node.lineno}: write `from ... import ...` or `import ... as ...`, one a line")


def _part(module: str) -> bool:
    return module.split(".")[0] in PARTS


def nest(root: Path, package: Path, stubs: bool = False) -> None:
    """Write the packages of the checkout `root` into the folder `package`, or their Python files alone as .pyi stubs.

    Raises ValueError, with file and line, for an import that cannot be nested.
    """
    for source in _sources(root):
        relative = source.relative_to(root)
        target = package / (relative.relative_to(WHOLE) if relative.parts[0] == WHOLE else relative)
        target.parent.mkdir(parents=True, exist_ok=True)
        if source.suffix == ".py":
            text = _nested_file(source.read_bytes(), str(source))
            target.with_suffix(".pyi" if stubs else ".py").write_bytes(text.encode())
        elif not stubs:
            target.write_bytes(source.read_bytes())


def _sources(root: Path) -> list[Path]:
    files = [file for package in (*PARTS, WHOLE) for file in (root / package).rglob("*")]
    return [file for file in files if file.is_file() and "__pycache__" not in file.parts]


def _nested_file(content: bytes, path: str) -> str:
    """A file's nested source; invalid Python stays unchanged, and fails in the compiler."""
    try:
        return nested(content.decode())
    except SyntaxError:
        return content.decode()
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None


class NestedLoader(SourceFileLoader):
    """Loads a checkout's file with nested imports, and keeps its bytecode apart from that of the plain module."""

    def source_to_code(self, data: Any, path: Any, *, _optimize: int = -1) -> CodeType:  # type: ignore[override]
        """Compile the nested source under the path of the checkout's file."""
        return super().source_to_code(_nested_file(bytes(data), str(path)).encode(), path, _optimize=_optimize)

    def path_stats(self, path: str) -> dict[str, Any]:
        """The conditions of valid bytecode: time and size of the source, and time of this module's file."""
        stats = dict(super().path_stats(path))
        return stats | {"mtime": stats["mtime"] + os.stat(__file__).st_mtime}

    def get_data(self, path: str) -> bytes:
        """Read a source, or its nested bytecode."""
        return super().get_data(_nested_cache(path))

    def set_data(self, path: str, data: Any, **options: Any) -> None:
        """Write the nested bytecode, beside and renamed; nothing where the place cannot be written."""
        super().set_data(_nested_cache(path), data, **options)


def _nested_cache(path: str) -> str:
    """The name of nested bytecode, `field.nested.cpython-311.pyc`; any further path unchanged."""
    folder, name = os.path.split(path)
    return os.path.join(folder, name.replace(".", ".nested.", 1)) if name.endswith(BYTECODE) else path


class NestedFinder:
    """Finds magbench and magbench.PART in a checkout, where no path entry leads to them."""

    def __init__(self, root: str) -> None:
        self.root = root

    def find_spec(
        self, name: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """A spec for magbench and all below it, None for all else."""
        whole, _, below = name.partition(".")
        if whole != WHOLE:
            return None
        spec = PathFinder.find_spec(name, [self.root] if below in ("", *PARTS) else path, target)
        if spec is not None and isinstance(spec.loader, SourceFileLoader):
            spec.loader = NestedLoader(name, spec.loader.path)
        return spec


def find_checkout(root: str) -> ModuleSpec | None:
    """Find magbench for an editable installation of the checkout `root`, when a program imports it.

    A checkout on the path, as in its own tests, comes before the installation. Raises ModuleNotFoundError where the
    checkout has gone.
    """
    plain = PathFinder.find_spec(WHOLE)
    if plain is not None and plain.origin:  # a folder of data of this name has no origin
        return plain
    finder = NestedFinder(root)
    sys.meta_path.insert(0, finder)
    return finder.find_spec(WHOLE)

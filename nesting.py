"""The packages of this repository as one package: `sim/field.py` becomes `magbench/sim/field.py`.

setup.py nests them when a wheel is built, so that a user's project may have a `sim` of its own. An editable
installation nests them under build/ and copies what has changed when a program imports magbench (as meson-python's
editable installations rebuild): real files under one path entry, which type checkers and numba's cache find too.
This file is copied into an editable installation and imports little, since every start of Python reads it; for pytest,
which warns of a plugin's modules that it finds imported: PYTEST_DONT_REWRITE.
"""

from __future__ import annotations

import sys

TYPE_CHECKING = False  # as typing's, whose import would cost every start of Python
if TYPE_CHECKING:
    import ast
    from pathlib import Path

WHOLE = "magbench"
PARTS = ("scenarios", "recordings", "sim", "calib", "validation", "diagnosis", "reports", "papers")
EDITABLE = "build/editable"
"""Where an editable installation keeps the nested package, below the repository's root."""


def nest(root: Path, out: Path) -> None:
    """Make `out`/magbench of the packages in `root`; copies that are as old as their source stay as they are."""
    targets = {_target(source.relative_to(root), out): source for source in _sources(root)}
    for target, source in targets.items():
        if not target.exists() or target.stat().st_mtime_ns != source.stat().st_mtime_ns:
            _copy(source, target)
    for old in (out / WHOLE).rglob("*"):
        if old.is_file() and old not in targets and "__pycache__" not in old.parts:
            old.unlink(missing_ok=True)


def nested(text: str) -> str:
    """A module's source with its imports of PARTS as imports of magbench.PART; every line keeps its number.

    Raises ValueError for `import sim.field`, which binds a name that the nested package does not have.
    """
    import ast

    lines = text.encode().splitlines(keepends=True)
    for node in ast.walk(ast.parse(text)):
        old, new = _heads(node)
        if old:
            line, column = lines[node.lineno - 1], node.col_offset
            assert line[column:].startswith(old)
            lines[node.lineno - 1] = line[:column] + new + line[column + len(old) :]
    return b"".join(lines).decode()


def _heads(node: ast.AST) -> tuple[bytes, bytes]:
    """How an import of PARTS begins, and how it begins in the nested package; empty for every other node."""
    import ast

    if isinstance(node, ast.ImportFrom):
        return (b"from ", f"from {WHOLE}.".encode()) if _part(node.module or "") else (b"", b"")
    if not isinstance(node, ast.Import) or not any(_part(alias.name) for alias in node.names):
        return b"", b""
    match node.names:
        case [ast.alias(name=str(name))] if "." not in name:
            return b"import ", f"from {WHOLE} import ".encode()
        case [ast.alias(asname=str())]:
            return b"import ", f"import {WHOLE}.".encode()
    raise ValueError(f"line {node.lineno}: write `from ... import ...` or `import ... as ...`, one a line")


def _part(module: str) -> bool:
    return module.split(".")[0] in PARTS


def _sources(root: Path) -> list[Path]:
    files = [file for package in (*PARTS, WHOLE) for file in (root / package).rglob("*")]
    return [file for file in files if file.is_file() and "__pycache__" not in file.parts]


def _target(relative: Path, out: Path) -> Path:
    return out / relative if relative.parts[0] == WHOLE else out / WHOLE / relative


def _copy(source: Path, target: Path) -> None:
    """Write beside and rename, so that programs which start at once do not meet half a file."""
    import os

    content = source.read_bytes()
    if source.suffix == ".py":
        try:
            content = nested(content.decode()).encode()
        except SyntaxError:  # told best by the import of the module itself
            pass
        except ValueError as error:
            raise ValueError(f"{source}: {error}") from None
    target.parent.mkdir(parents=True, exist_ok=True)
    beside = target.with_name(f"{target.name}.{os.getpid()}")
    beside.write_bytes(content)
    stat = source.stat()
    os.utime(beside, ns=(stat.st_atime_ns, stat.st_mtime_ns))
    beside.replace(target)


class KeepCurrent:
    """On sys.meta_path of an editable installation: nests what has changed before magbench is imported."""

    def __init__(self, root: str) -> None:
        self.root = root

    def find_spec(self, name: str, path: object = None, target: object = None) -> None:
        """Nothing: the finders that follow find the module."""
        if name == WHOLE:
            sys.meta_path.remove(self)
            self.nest()

    def nest(self) -> None:
        """Make the copy anew, unless the checkout itself comes first, as in its own tests.

        A copy that was removed is off the path, since the interpreter leaves out what is not there at its start.
        Raises ModuleNotFoundError where the repository has gone too.
        """
        import os

        copy = os.path.join(self.root, EDITABLE)
        if copy not in sys.path:
            sys.path.append(copy)
        if next(place for place in sys.path if place == copy or os.path.isdir(os.path.join(place, WHOLE))) != copy:
            return
        if not os.path.isdir(os.path.join(self.root, WHOLE)):
            what = f"{self.root} has gone, where {WHOLE} is installed from: install it anew from where it is now"
            raise ModuleNotFoundError(f"{what} (pip install -e .)", name=WHOLE)
        import importlib
        from pathlib import Path

        nest(Path(self.root), Path(copy))
        importlib.invalidate_caches()  # the path may be known as a directory that is not there


def keep_current(root: str) -> None:
    """Called by the installation's .pth file."""
    sys.meta_path.insert(0, KeepCurrent(root))

"""The import rules that keep the architecture: read from the source, so that lazy imports count too."""

from __future__ import annotations

import ast
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
ORDER = ("scenarios", "sim", "calib", "validation", "magbench")
FILES = [path for package in ORDER for path in sorted((ROOT / package).rglob("*.py"))]


def imported(path: Path) -> Iterator[str]:
    """Every module that a file names in an import, as `package.module.Name`."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def package_of(path: Path) -> str:
    return path.relative_to(ROOT).parts[0]


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(ROOT)))
def test_a_package_imports_only_from_its_left(path: Path) -> None:
    allowed = ORDER[: ORDER.index(package_of(path)) + 1]
    wrong = [name for name in imported(path) if name.split(".")[0] in ORDER and name.split(".")[0] not in allowed]
    assert not wrong


def test_a_calibrator_cannot_name_the_truth() -> None:
    seen = {name for path in (ROOT / "calib").rglob("*.py") for name in imported(path) if name.split(".")[0] == "sim"}
    assert seen <= {"sim.dataset.Recording"}


@pytest.mark.parametrize(
    ("library", "home"),
    [
        ("mujoco", lambda p: package_of(p) == "sim"),
        ("rerun", lambda p: (ROOT / "validation" / "views" / "recording") in p.parents),
        ("matplotlib", lambda p: (ROOT / "validation" / "views" / "plots") in p.parents),
        ("filterpy", lambda p: package_of(p) == "calib"),
    ],
)
def test_a_library_is_used_in_its_one_place(library: str, home) -> None:  # type: ignore[no-untyped-def]
    users = [path for path in FILES if any(name.split(".")[0] == library for name in imported(path))]
    assert not [str(path) for path in users if not home(path)]


def test_reading_a_dataset_does_not_load_the_engine(run_python) -> None:  # type: ignore[no-untyped-def]
    code = "import sys, sim.dataset, calib; sys.exit('mujoco' in sys.modules)"
    assert run_python(code).returncode == 0


def test_no_address_of_a_registry_and_no_path_of_a_machine() -> None:
    tracked = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True)
    if tracked.returncode:
        pytest.skip("not a git checkout")
    marks = ("index-" + "url", "/ro" + "ot/", "/ho" + "me/", "/wo" + "rk/", "pypi" + ".org")
    texts = {name: (ROOT / name) for name in tracked.stdout.split()}
    found = [
        (name, mark)
        for name, path in texts.items()
        if path.suffix in {".py", ".toml", ".txt", ".md", ".xml", ".html", ""} and path.is_file()
        for mark in marks
        if mark in path.read_text(encoding="utf-8", errors="replace")
    ]
    assert not found

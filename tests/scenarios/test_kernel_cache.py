"""Compiled code is kept apart by name and by what its source depends on."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path

import pytest

from scenarios import kernel_cache
from scenarios.kernel_cache import KERNEL, digest
from tests.conftest import ROOT
from tests.imports import FILES, name_of

KERNELS = [path for path in FILES if KERNEL.search(path.read_bytes())]
TYPES = """
from typing import NamedTuple
class Pair(NamedTuple):
    a: float
    b: float
"""
TWICE = "from {place}scenarios.kernel_cache import njit\n@njit(cache=True)\ndef twice(x):\n    return {factor} * x\n"
TOTAL = """
from scenarios.kernel_cache import njit
from sim.twice import twice
from sim.types import Pair
@njit(cache=True)
def total(pair):
    return twice(pair.a) + pair.b
"""
USE = "from {place}sim.total import total; from {place}sim import types\n"
USE += "print(total(types.{name}(1.0, 2.0)), sum(total.stats.cache_misses.values()))"


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """A checkout with two kernels, of which the first takes a type and calls the second."""
    for package in ("scenarios", "sim", "magbench"):
        (tmp_path / package).mkdir()
        (tmp_path / package / "__init__.py").touch()
    for name in ("scenarios/kernel_cache.py", "nesting.py"):
        (tmp_path / name).write_bytes((ROOT / name).read_bytes())
    (tmp_path / "sim" / "types.py").write_text(TYPES)
    (tmp_path / "sim" / "twice.py").write_text(TWICE.format(place="", factor=2))
    (tmp_path / "sim" / "total.py").write_text(TOTAL)
    return tmp_path


@pytest.fixture
def run(tree: Path) -> Callable[[str], str]:
    """Run code that finds the tree, plain and as an editable installation does, and print."""

    def call(code: str) -> str:
        nested = f"import sys; sys.path.append({str(tree)!r}); import nesting\n"
        nested += f"sys.meta_path.insert(0, nesting.NestedFinder({str(tree)!r}))\n"
        environment = {key: value for key, value in os.environ.items() if key not in ("NUMBA_CACHE_DIR", "PYTHONPATH")}
        command = [sys.executable, "-c", nested + code]
        done = subprocess.run(command, cwd=tree.parent, capture_output=True, text=True, env=environment)
        assert done.returncode == 0, done.stderr
        return done.stdout.strip()

    return call


def folders(tree: Path, stem: str) -> list[str]:
    return sorted(path.name.rsplit(".", 1)[0] for path in (tree / "sim" / "__pycache__").glob(f"*.{stem}.*/"))


def test_two_names_in_one_process_load_each_its_own(tree: Path, run: Callable[[str], str]) -> None:
    both = USE.format(place="", name="Pair") + "\n" + USE.format(place="magbench.", name="Pair")
    assert run(both).splitlines() == ["4.0 1", "4.0 1"]
    assert run(both).splitlines() == ["4.0 0", "4.0 0"]
    assert folders(tree, "total") == ["nested.total", "plain.total"]


@pytest.mark.slow
def test_a_type_renamed_in_another_file_is_compiled_anew(tree: Path, run: Callable[[str], str]) -> None:
    assert run(USE.format(place="", name="Pair")) == "4.0 1"
    for file in ("types.py", "total.py"):
        path = tree / "sim" / file
        path.write_text(path.read_text().replace("Pair", "Couple"))
    (tree / "sim" / "total.py").write_text(TOTAL.replace("import Pair", "import Couple"))
    assert run(USE.format(place="", name="Couple")) == "4.0 1"
    assert folders(tree, "total") == ["plain.total"], "the folder of the earlier source is left"


def test_a_kernel_changed_in_another_file_is_compiled_anew(tree: Path, run: Callable[[str], str]) -> None:
    """As numba alone does not: the earlier code of the other kernel is within the compiled one."""
    assert run(USE.format(place="", name="Pair")) == "4.0 1"
    (tree / "sim" / "twice.py").write_text(TWICE.format(place="", factor=5))
    assert run(USE.format(place="", name="Pair")) == "7.0 1"


@pytest.mark.parametrize("path", KERNELS, ids=name_of)
def test_every_kernel_is_kept_so(path: Path) -> None:
    """No module of this package compiles by numba's own decorator."""
    module = name_of(path).removesuffix(".py").replace("/", ".")
    if path != Path(kernel_cache.__file__):
        assert "from numba import njit" not in path.read_text(encoding="utf-8")
    kernels = [value for value in vars(import_module(module)).values() if hasattr(value, "py_func")]
    own = [kernel for kernel in kernels if kernel.py_func.__module__ == module]
    assert all(f"plain.{path.stem}.{digest(module)}" in kernel._cache.cache_path for kernel in own)


def test_a_function_of_another_package_is_kept_by_numba(tmp_path: Path) -> None:
    (tmp_path / "theirs.py").write_text("import numba\n@numba.njit(cache=True)\ndef f(x):\n    return x\n")
    code = "import scenarios.kernel_cache, sys; sys.path.insert(0, sys.argv[1]); import theirs\n"
    code += "print(theirs.f._cache.cache_path)"
    command = [sys.executable, "-c", code, str(tmp_path)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    assert "plain." not in done.stdout

"""The packages nested in magbench: imports rewritten, nothing else changed, in a wheel's copy and in place."""

from __future__ import annotations

import ast
import importlib.util
import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from nesting import HOOK, PARTS, nest, nested
from tests.conftest import ROOT

MODULES = [path for package in (*PARTS, "magbench") for path in sorted((ROOT / package).rglob("*.py"))]


@pytest.mark.parametrize(
    ("plain", "inside"),
    [
        ("from sim.field import a\n", "from magbench.sim.field import a\n"),
        ("from sim import effects as e\n", "from magbench.sim import effects as e\n"),
        ("import calib\n", "from magbench import calib\n"),
        ("import calib as c\n", "from magbench import calib as c\n"),
        ("import sim.field as f\n", "import magbench.sim.field as f\n"),
        ("def f():\n    from sim.field import (\n        a,\n    )\n", None),
        ("é = 1; from sim import b\n", "é = 1; from magbench.sim import b\n"),
        ("from simulation import a\nimport os, sys\nx = 'from sim import a'\n", ""),
    ],
)
def test_imports_of_our_packages_alone_are_rewritten(plain: str, inside: str | None) -> None:
    expected = plain.replace("from sim", "from magbench.sim") if inside is None else inside or plain
    assert nested(plain) == expected


@pytest.mark.parametrize("text", ["import sim.field\n", "import os, calib\n"])
def test_an_import_that_cannot_be_nested_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match="line 1"):
        nested(text)


def test_no_module_looks_for_a_package_beside_magbench() -> None:
    """Neither by an import nor by a name in a string, which the rewriting would not see."""
    found = {str(path.relative_to(ROOT)): beside for path in MODULES if (beside := _looked_for_beside(path))}
    assert not found


def _looked_for_beside(path: Path) -> list[str]:
    """Our packages that a nested file would look for by their plain names."""
    nodes = list(ast.walk(ast.parse(nested(path.read_text(encoding="utf-8")))))
    texts = [node.value for node in nodes if isinstance(node, ast.Constant) and isinstance(node.value, str)]
    dotted = [text for text in texts if text.split(".")[0] in PARTS and text.replace(".", "").isidentifier()]
    return [name for name in _imported(nodes) if name.split(".")[0] in PARTS] + [
        text for text in dotted if "." in text and importlib.util.find_spec(text)
    ]


def _imported(nodes: list[ast.AST]) -> list[str]:
    imports = [node.module or "" for node in nodes if isinstance(node, ast.ImportFrom)]
    imports += [alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names]
    return imports


FIELD = """from calib import x


def scaled(factor):
    from calib.more import y

    return factor * x * y
"""
FINDER = f"""
import importlib.util, os, sys, traceback
spec = importlib.util.spec_from_file_location("nesting", {str(ROOT / "nesting.py")!r})
nesting = importlib.util.module_from_spec(spec)
spec.loader.exec_module(nesting)
sys.meta_path.insert(0, nesting.NestedFinder(sys.argv[1]))
"""


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """The root of a checkout with a few files."""
    root = tmp_path / "checkout"
    for package in (*PARTS, "magbench"):
        (root / package).mkdir(parents=True)
        (root / package / "__init__.py").write_text("")
    (root / "calib" / "__init__.py").write_text("x = 2\n")
    (root / "calib" / "more.py").write_text("y = 3\n")
    (root / "sim" / "field.py").write_text(FIELD)
    (root / "sim" / "models").mkdir()
    (root / "sim" / "models" / "a.xml").write_text("<sim/>")
    return root


@pytest.fixture
def run(tree: Path, tmp_path: Path) -> Callable[[str], list[str]]:
    """Run code elsewhere in a program that finds magbench in `tree`; the lines that it prints."""

    def call(code: str) -> list[str]:
        command = [sys.executable, "-c", FINDER + code, str(tree)]
        environment = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, env=environment)
        assert done.returncode == 0, done.stderr
        return done.stdout.splitlines()

    return call


def test_a_wheel_gets_nested_files_and_data(tree: Path, tmp_path: Path) -> None:
    nest(tree, tmp_path / "magbench")
    assert (tmp_path / "magbench" / "sim" / "field.py").read_text().startswith("from magbench.calib import x\n")
    assert (tmp_path / "magbench" / "sim" / "models" / "a.xml").read_text() == "<sim/>"
    assert (tmp_path / "magbench" / "__init__.py").is_file()


def test_a_type_checker_gets_stubs_of_the_python_files(tree: Path, tmp_path: Path) -> None:
    nest(tree, tmp_path / "stubs", stubs=True)
    assert (tmp_path / "stubs" / "sim" / "field.pyi").read_text().startswith("from magbench.calib import x\n")
    assert {file.suffix for file in (tmp_path / "stubs").rglob("*.*")} == {".pyi"}


def test_a_checkouts_own_files_are_imported_under_the_nested_names(tree: Path, run: Callable[[str], list[str]]) -> None:
    code = "import magbench.sim.field as f; print(f.__file__); print(f.scaled.__code__.co_filename); print(f.scaled(7))"
    path = str(tree / "sim" / "field.py")
    assert run(code) == [path, path, "42"]
    assert run(f"{code}; print(*sys.modules)")[-1].split().count("magbench.calib.more") == 1
    assert not {"sim", "calib", "calib.more"} & set(run("import magbench.sim.field; print(*sys.modules)")[0].split())


def test_an_edit_acts_at_the_next_start(tree: Path, run: Callable[[str], list[str]]) -> None:
    code = "from magbench.sim.field import scaled; print(scaled(1))"
    assert run(code) == ["6"]
    (tree / "calib" / "more.py").write_text("y = 50\n")
    assert run(code) == ["100"]


def test_bytecode_is_kept_apart_from_that_of_the_plain_module(tree: Path, run: Callable[[str], list[str]]) -> None:
    code = f"from magbench.sim.field import scaled; sys.path.insert(0, {str(tree)!r}); import sim.field as plain\n"
    code += "print(plain.__name__, scaled.__module__, plain.scaled is scaled, plain.scaled(1) == scaled(1))"
    for _ in range(2):
        assert run(code) == ["sim.field magbench.sim.field False True"]
    names = {file.name for file in (tree / "sim" / "__pycache__").glob("field.*")}
    tag = sys.implementation.cache_tag
    assert names == {f"field.{tag}.pyc", f"field.nested.{tag}.pyc"}
    time_ns = (tree / "sim" / "__pycache__" / f"field.nested.{tag}.pyc").stat().st_mtime_ns
    run(code)
    assert (tree / "sim" / "__pycache__" / f"field.nested.{tag}.pyc").stat().st_mtime_ns == time_ns


def test_a_checkout_that_cannot_be_written_is_imported(tree: Path, run: Callable[[str], list[str]]) -> None:
    for package in (*PARTS, "magbench"):
        (tree / package / "__pycache__").write_text("a file where the folder of bytecode would be")
    assert run("from magbench.sim.field import scaled; print(scaled(1))") == ["6"]


def test_a_traceback_and_the_source_are_those_of_the_file(tree: Path, run: Callable[[str], list[str]]) -> None:
    code = """
import inspect
from magbench.sim.field import scaled
try:
    scaled(None)
except TypeError as error:
    last = traceback.extract_tb(error.__traceback__)[-1]
print(last.filename, last.lineno, last.line)
print(inspect.getsource(scaled).splitlines()[1].strip())
"""
    assert run(code) == [f"{tree / 'sim' / 'field.py'} 7 return factor * x * y", "from calib.more import y"]


def test_a_debugger_stops_at_the_lines_of_the_file(tree: Path, run: Callable[[str], list[str]]) -> None:
    code = """
import bdb
from magbench.sim.field import scaled

class Stepper(bdb.Bdb):
    def user_line(self, frame):
        print(frame.f_code.co_filename, frame.f_lineno)
        self.set_continue()

stepper = Stepper()
assert stepper.set_break(sys.argv[1] + "/sim/field.py", 7) is None
stepper.set_trace = lambda *_: None
stepper.runcall(scaled, 1)
"""
    assert f"{tree / 'sim' / 'field.py'} 7" in run(code)


def test_coverage_measures_the_file(tree: Path, run: Callable[[str], list[str]]) -> None:
    code = """
import coverage
measured = coverage.Coverage(data_file=None, include=[sys.argv[1] + "/*"], config_file=False)
measured.start()
from magbench.sim.field import scaled
measured.stop()
_, statements, _, missing, _ = measured.analysis2(sys.argv[1] + "/sim/field.py")
print(statements, missing)
"""
    assert run(code) == ["[1, 4, 5, 7] [5, 7]"]


def test_a_syntax_error_is_told_with_file_and_line(tree: Path, run: Callable[[str], list[str]]) -> None:
    (tree / "sim" / "field.py").write_text("x = 1\nfrom calib import\n")
    code = """
try:
    import magbench.sim.field
except SyntaxError as error:
    print(error.filename, error.lineno)
"""
    assert run(code) == [f"{tree / 'sim' / 'field.py'} 2"]


def test_an_import_that_cannot_be_nested_is_told_with_its_file(tree: Path, run: Callable[[str], list[str]]) -> None:
    (tree / "sim" / "field.py").write_text("import calib.more\n")
    code = """
try:
    import magbench.sim.field
except ValueError as error:
    print(error)
"""
    (told,) = run(code)
    assert told.startswith(f"{tree / 'sim' / 'field.py'}: line 1: write")


def test_a_checkout_on_the_path_comes_before_the_installation(tree: Path, run: Callable[[str], list[str]]) -> None:
    code = "del sys.meta_path[0]; sys.path.insert(0, sys.argv[1]); spec = nesting.find_checkout('/nowhere')\n"
    code += "print(spec.origin, type(spec.loader).__name__, type(sys.meta_path[0]).__name__ == 'NestedFinder')"
    assert run(code) == [f"{tree / 'magbench' / '__init__.py'} SourceFileLoader False"]


def test_a_folder_of_data_called_magbench_is_no_checkout(tmp_path: Path, run: Callable[[str], list[str]]) -> None:
    (tmp_path / "magbench").mkdir()
    code = "sys.path = ['', *(p for p in sys.path if not os.path.isfile(p + '/magbench/__init__.py'))]\n"
    code += "del sys.meta_path[0]; print(type(nesting.find_checkout(sys.argv[1]).loader).__name__)"
    assert run(code) == ["NestedLoader"]


def test_an_installation_whose_repository_has_gone_says_so(tmp_path: Path) -> None:
    (tmp_path / "hook.py").write_text(HOOK.format(root=str(tmp_path / "gone")))
    done = subprocess.run([sys.executable, "-c", "import hook, magbench"], cwd=tmp_path, capture_output=True, text=True)
    last = done.stderr.splitlines()[-1]
    assert "gone has gone, where magbench is installed from: install it anew" in last
    assert last.startswith("ModuleNotFoundError")


@pytest.mark.parametrize("page", [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))], ids=lambda p: p.name)
def test_public_examples_import_magbench_alone(page: Path) -> None:
    for snippet in re.findall(r"^```python\n(.*?)^```$", page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL):
        assert nested(snippet) == snippet

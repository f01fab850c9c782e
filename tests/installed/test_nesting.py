"""The packages nested in magbench: imports rewritten, nothing else changed, copies kept current."""

from __future__ import annotations

import ast
import importlib.util
import os
import re
import sys
from pathlib import Path

import pytest

from nesting import EDITABLE, PARTS, KeepCurrent, nest, nested
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


@pytest.mark.parametrize("path", MODULES, ids=lambda p: str(p.relative_to(ROOT)))
def test_no_module_looks_for_a_package_beside_magbench(path: Path) -> None:
    """Neither by an import nor by a name in a string, which the rewriting would not see."""
    tree = ast.parse(nested(path.read_text(encoding="utf-8")))
    assert not [name for name in _imported(tree) if name.split(".")[0] in PARTS]
    texts = [node.value for node in ast.walk(tree) if isinstance(node, ast.Constant) and isinstance(node.value, str)]
    dotted = [text for text in texts if text.split(".")[0] in PARTS and text.replace(".", "").isidentifier()]
    assert not [text for text in dotted if "." in text and importlib.util.find_spec(text)]


def _imported(tree: ast.Module) -> list[str]:
    imports = [node.module or "" for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
    imports += [alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names]
    return imports


def small_tree(root: Path) -> None:
    for package in (*PARTS, "magbench"):
        (root / package).mkdir(parents=True)
        (root / package / "__init__.py").write_text("")
    (root / "sim" / "field.py").write_text("from calib import x\n")
    (root / "sim" / "models").mkdir()
    (root / "sim" / "models" / "a.xml").write_text("<sim/>")


def test_a_copy_follows_its_source_and_goes_with_it(tmp_path: Path) -> None:
    small_tree(tmp_path)
    out = tmp_path / "out"
    nest(tmp_path, out)
    copy = out / "magbench" / "sim" / "field.py"
    assert copy.read_text() == "from magbench.calib import x\n"
    assert (out / "magbench" / "sim" / "models" / "a.xml").read_text() == "<sim/>"
    before = copy.stat()
    nest(tmp_path, out)
    assert copy.stat().st_ino == before.st_ino, "written again though nothing had changed"
    (tmp_path / "sim" / "field.py").write_text("from calib import y\n")
    os.utime(tmp_path / "sim" / "field.py", ns=(0, before.st_mtime_ns - 1))  # an older one, as git may bring back
    nest(tmp_path, out)
    assert copy.read_text() == "from magbench.calib import y\n"
    (tmp_path / "sim" / "field.py").unlink()
    nest(tmp_path, out)
    assert not copy.exists()


@pytest.fixture
def alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """A path without this checkout."""
    monkeypatch.setattr(sys, "path", [place for place in sys.path if not (Path(place) / "magbench").is_dir()])


@pytest.mark.usefixtures("alone")
def test_an_editable_installation_makes_a_copy_that_was_removed(tmp_path: Path) -> None:
    small_tree(tmp_path)
    copy = tmp_path / EDITABLE
    KeepCurrent(str(tmp_path)).nest()
    assert (copy / "magbench" / "sim" / "field.py").read_text() == "from magbench.calib import x\n"
    assert sys.path[-1] == str(copy), "the interpreter leaves out a path that is not there at its start"


@pytest.mark.usefixtures("alone")
def test_an_editable_installation_whose_repository_has_gone_says_so(tmp_path: Path) -> None:
    with pytest.raises(ModuleNotFoundError, match=r"gone.*has gone, where magbench is installed from: install it anew"):
        KeepCurrent(str(tmp_path / "gone")).nest()
    assert not (tmp_path / "gone").exists()


def test_a_checkout_on_the_path_comes_before_the_copy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    small_tree(tmp_path)
    monkeypatch.setattr(sys, "path", [str(tmp_path)])
    KeepCurrent(str(tmp_path)).nest()
    assert not (tmp_path / EDITABLE).exists()


def test_a_module_that_is_no_python_is_left_for_its_import_to_tell(tmp_path: Path) -> None:
    small_tree(tmp_path)
    (tmp_path / "sim" / "field.py").write_text("from calib import\n")
    nest(tmp_path, tmp_path / "out")
    assert (tmp_path / "out" / "magbench" / "sim" / "field.py").read_text() == "from calib import\n"


@pytest.mark.parametrize("page", [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))], ids=lambda p: p.name)
def test_public_examples_import_magbench_alone(page: Path) -> None:
    for snippet in re.findall(r"^```python\n(.*?)^```$", page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL):
        assert nested(snippet) == snippet

"""The site: every page is reached from its first, docstrings and help become pages, and the whole builds silently."""

from __future__ import annotations

import io
import json
import re
import runpy
import shlex
import tomllib
from pathlib import Path

import artwork
import book
import docstrings
import executed
import numpy as np
import pytest
import reference_pages
import result_keys
import shown
from matplotlib import pyplot
from PIL import Image

import magbench
from diagnosis.verdict import Verdict
from magbench.cli import main
from magbench.commands.schema import SchemaKind, schema_of
from tests.conftest import ROOT

TREE = re.compile(r"^:::\{toctree\}\n(.*?)^:::$", re.MULTILINE | re.DOTALL)
MOST_CLICKS = 3
GALLERY = "pictures_of/"
"""Pages that sphinx-gallery writes as the site is built."""
EXAMPLES = sorted((ROOT / "docs" / "gallery").glob("*/*.py"))
FEWEST_PICTURES, MOST_LINES = 30, 40
MOST_BYTES = 60_000
"""Of a logo, a badge or the social card."""
EFFECT = ("", "NamedEffectJson")


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The copy that Sphinx reads."""
    folder = tmp_path_factory.mktemp("book")
    book.copy(folder)
    return folder


def below(page: Path) -> set[Path]:
    """The pages of a page's tables of contents."""
    entries = (line for tree in TREE.findall(page.read_text(encoding="utf-8")) for line in tree.splitlines())
    names = (entry for entry in entries if entry and not entry.startswith((":", GALLERY)))
    return {page.parent / f"{name}.md" for name in names}


def test_every_page_is_reached_in_three_clicks(source: Path) -> None:
    reached = {source / "index.md"}
    for _ in range(MOST_CLICKS):
        reached |= {page.resolve() for known in reached for page in below(known)}
    assert not [page for page in reached if not page.is_file()]
    assert not {page.relative_to(source) for page in source.rglob("*.md")} - {p.relative_to(source) for p in reached}


def test_every_public_name_and_command_has_a_page(source: Path) -> None:
    assert {path.stem for path in (source / "api").iterdir()} == {*magbench.__all__, "index"}
    text = (source / "commands" / "calibrate.md").read_text(encoding="utf-8")
    assert "| `--with` | NAME,... |" in text
    assert "Default: 60.0." in text


def test_a_page_that_is_gone_is_removed_and_one_that_stayed_keeps_its_time(source: Path) -> None:
    (source / "old.md").write_text("# Old\n", encoding="utf-8")
    time = (source / "index.md").stat().st_mtime_ns
    book.copy(source)
    assert not (source / "old.md").exists()
    assert (source / "index.md").stat().st_mtime_ns == time


def test_versions_in_folders_beside_each_other_are_known_to_all(tmp_path: Path) -> None:
    for folder, version in (("site-0.0.9", "0.0.9"), ("site", "")):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / book.VERSION).write_text(version)
    book.list_versions(tmp_path / "site")
    text = (tmp_path / book.VERSIONS).read_text(encoding="utf-8").removeprefix("window.magbenchVersions = ")
    assert json.loads(text.removesuffix(";\n")) == {"site": magbench.__version__, "site-0.0.9": "0.0.9"}


def test_logo_and_badges_are_as_drawn_and_true() -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    for path, content in artwork.files():
        assert path.suffix == ".png" or path.read_bytes() == content
        assert path.stat().st_size < MOST_BYTES
    with Image.open(artwork.STYLE / "card.png") as kept, Image.open(io.BytesIO(artwork.card())) as anew:
        assert kept.size == anew.size
    assert artwork.facts()["license"][1] in readme
    assert f"Python {' to '.join(artwork.TESTED)}" in readme
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert project["requires-python"] == f">={artwork.TESTED[0]}"
    workflow = (ROOT / ".github" / "workflows" / "ci.yml").read_text(encoding="utf-8")
    assert f"python: {json.dumps(artwork.TESTED)}" in workflow


@pytest.mark.parametrize("kind", ["diagnose", "bound", "calibrations"])
def test_the_page_of_a_result_has_every_key_of_its_schema(source: Path, kind: str) -> None:
    text = (source / "schemas" / f"{kind}.md").read_text(encoding="utf-8").split("```json")[0]
    tables = schema_of(SchemaKind(kind)).get("$defs", {})
    for name, table in tables.items():
        assert f"## {result_keys.words(name)}\n" in text
        assert all(f"| `{key}` |" in text for key in table.get("properties", ()))


def test_keys_of_a_result_are_told_with_their_place_and_kind() -> None:
    own, effect, *_ = (one for one in result_keys.tables(schema_of(SchemaKind.DIAGNOSE)) if one.name in EFFECT)
    assert ("gap", "[gap]", "the residual before and after") in own.rows
    assert "effects[]" in effect.paths
    assert {"stated", "corrected", "only_in"} <= {name for name, _, _ in effect.rows}
    kinds = {name: kind for name, kind, _ in result_keys.tables(schema_of(SchemaKind.BOUND))[0].rows}
    assert (kinds["offset_std_nT"], kinds["eddy_std_s"]) == ("3 numbers", "list of 3 numbers; may be left out")
    assert kinds["unobservable"] == "list of [unobservable]"


def test_arguments_of_a_docstring_become_fields() -> None:
    lines = [
        "The sum, in F = |h|.",
        "",
        "a, b : numbers",
        "    of any size. c_ : third; *starred*.",
        "",
        ">>> 1",
        "1",
    ]
    assert [line for line in docstrings.rewritten(lines, {"b": "float"}) if line] == [
        *(r"The sum, in F = \|h\|.", ":param a: numbers of any size.", ":param b: see `a`", ":type b: float"),
        *(r":param c\_: third; \*starred\*.", ">>> 1\n1"),
    ]


def test_options_in_a_help_text_are_code_and_its_signs_are_signs() -> None:
    assert reference_pages.as_markdown("For --with a|b, `x|y`.") == r"For `--with` a\|b, `x|y`."


@pytest.mark.slow
def test_the_site_builds_without_a_warning_and_asks_for_nothing_of_the_network(tmp_path: Path) -> None:
    for package in ("myst_parser", "sphinx_design", "sphinx_copybutton", "pydata_sphinx_theme"):
        pytest.importorskip(package, reason="the site is built where the extra docs is installed")
    assert book.main(tmp_path) == 0
    pages = [page.read_text(encoding="utf-8") for page in (tmp_path / "site").rglob("*.html")]
    assert len(pages) > len(list((ROOT / "docs").glob("*.md")))
    fetched = r"<(?:script|img|link)[^>]*(?:src|href)=\"(?:https?:)?//"
    assert not [found for text in pages for found in re.findall(fetched, text)]


PAGE = """```sh
magbench list vehicles
```

```python
from matplotlib.figure import Figure

Figure()
```

```toml
# own.toml
name = "own"
```

```python
from pathlib import Path

Path("own.toml").read_text().count("own")
```
"""


def test_what_blocks_print_and_draw_stands_below_them(tmp_path: Path) -> None:
    (tmp_path / "tutorials").mkdir()
    text = executed.executed(PAGE, tmp_path, "tutorials/page")
    listed, drawn, counted = (
        part.split("```\n", 1)[1] for part in re.split("^```(?:sh|python)\n", text, flags=re.M)[1:]
    )
    assert "turntable" in listed
    assert "![`Figure()`](pictures/page-1.png)" in drawn
    assert (tmp_path / "tutorials" / "pictures" / "page-1.png").is_file()
    assert counted == "\n```text\n2\n```\n"


@pytest.mark.slow
@pytest.mark.parametrize("page", sorted((ROOT / "docs" / "tutorials").glob("*.md")), ids=lambda page: page.stem)
def test_every_block_of_a_tutorial_runs(page: Path, tmp_path: Path) -> None:
    (tmp_path / "tutorials").mkdir()
    executed.executed(page.read_text(encoding="utf-8"), tmp_path, f"tutorials/{page.stem}")


def test_a_command_that_fails_stops_the_build(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="tutorials/page: magbench list nothing"):
        executed.executed("```sh\nmagbench list nothing\n```\n", tmp_path, "tutorials/page")


def test_of_much_the_first_paragraph_is_shown_and_all_on_request() -> None:
    assert executed.printed("a\nb\n") == "\n```text\na\nb\n```\n"
    text = executed.printed("first\n\n" + "\n".join(f"line {k}" for k in range(40)))
    assert text.startswith("\n```text\nfirst\n```\n\n::::{dropdown} All 42 lines\n")
    assert "line 39\n" in text


def test_a_page_notes_a_line_once_and_no_progress() -> None:
    shown, known = io.StringIO(), set[str]()
    for _ in range(2):
        executed.Notes(shown, known).write("attitude: XKQ\nrunning: 4 %\nrunning: 0 %, 7 s\n")
    assert shown.getvalue() == "attitude: XKQ\n"


def test_the_gallery_shows_every_effect_and_verdict_in_few_lines() -> None:
    texts = {
        path.relative_to(ROOT / "docs" / "gallery").as_posix(): path.read_text(encoding="utf-8") for path in EXAMPLES
    }
    assert len(texts) == len(EXAMPLES) >= FEWEST_PICTURES
    assert not [name for name, text in texts.items() if len(text.splitlines()) > MOST_LINES]
    whole = "".join(texts.values())
    assert not [name for name in shown.kept()["names"]["effects"] if name not in re.findall(r"\w+", whole)]
    assert {path.stem for path in EXAMPLES if path.parent.name == "verdicts"} == set(Verdict)


@pytest.mark.slow
@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: f"{path.parent.name}-{path.stem}")
def test_every_example_of_the_gallery_runs(example: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(example.parent)
    monkeypatch.setenv("MPLBACKEND", "agg")
    runpy.run_path(str(example))
    pyplot.close("all")


REFUSAL = re.compile(r"^```console\n\$ magbench (.*)\n(magbench: .*)\n```", re.MULTILINE)
REFUSALS = REFUSAL.findall((ROOT / "docs" / "troubleshooting.md").read_text(encoding="utf-8"))


@pytest.mark.parametrize(("command", "told"), REFUSALS, ids=[told[10:40] for _, told in REFUSALS])
def test_a_command_is_refused_as_the_page_says(
    command: str, told: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "docs").symlink_to(ROOT / "docs")
    rng = np.random.default_rng(0)
    field_uT = rng.standard_normal((200, 3))
    field_uT *= 48.0 / np.linalg.norm(field_uT, axis=1, keepdims=True)
    rows = np.column_stack([0.1 * np.arange(200), field_uT])
    np.savetxt("log.csv", rows, delimiter=",", header="t,bx,by,bz", comments="")
    assert main(shlex.split(command)) == 2
    assert told in capsys.readouterr().err


def test_the_page_tells_of_several_refusals() -> None:
    assert len(REFUSALS) >= 7

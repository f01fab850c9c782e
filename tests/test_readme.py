"""README and docs are true: commands and snippets run, links lead somewhere, tables are what the code says."""

from __future__ import annotations

import contextlib
import importlib.util
import io
import re
import shlex
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType

import numpy as np
import peers
import pytest
import reproduced
import shown
import tables
from typer import TyperException

import magbench.viewer
import sim.scenario
import validation.comparison.engine
import validation.planning.refinement
from magbench.api.inputs import in_options
from magbench.app import program
from magbench.cli import main
from papers import PAPERS
from recordings import read_manifest
from scenarios.errors import InputError
from scenarios.load import catalogue
from sim.scenario import Scenario
from sim.state import State
from tests.conftest import ROOT
from tests.imports import ORDER
from tests.short import cuts
from validation.calibrating.export import FORMATS
from validation.comparison.engine import SerialEngine

PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
OTHERS = [ROOT / name for name in ("ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md", "REFERENCES.md")]
OTHERS += (ROOT / "docs").glob("*/*.md")
FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
KEY = re.compile(r"\[([A-Z][A-Za-z]+[12]\d{3})(?:, ([A-Z][A-Za-z]+[12]\d{3}))?\]")
QUICKEST = "zhou2012"
"""The paper that stands for all where a page reproduces one."""
LONG = (
    "own-calibrator",
    "calibrators",
    "measured",
    "python",
    "verdicts",
    "report",
    "scores",
    "dataset",
    "gates",
    "compare",
    "plan",
    "diagnosis",
    "logs",
    "tour",
)
"""Pages whose commands take three seconds and more: the nightly run follows them; by day their commands are parsed."""
MODULE = re.compile(r"# (\w+\.py)\n")
"""The first line of a snippet that is a file of the reader's."""
NOT_OURS = ("polars", "duckdb", "datasets")
"""Packages that a snippet may use and the project does not install."""


def blocks(page: Path) -> list[tuple[str, str]]:
    return FENCE.findall(page.read_text(encoding="utf-8"))


def shell_lines(page: Path) -> list[str]:
    text = "\n".join(code for language, code in blocks(page) if language == "sh")
    return [line for line in text.replace("\\\n", " ").splitlines() if line.strip()]


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, undrawn: None) -> Path:
    """A directory to work in, with the logs that the pages speak of; scenarios and searches are cut short.

    Trials are computed in this process, since others take longer to start.
    """
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HF_HUB_OFFLINE", "1")
    load = sim.scenario.load

    def short(name: str, overrides: Sequence[str] = ()) -> Scenario:
        return load(name, [*overrides, *(cuts(str(name)) if str(name) in catalogue() else ())])

    monkeypatch.setattr(sim.scenario, "load", short)
    monkeypatch.setattr(validation.planning.refinement, "STEPS_DEG", validation.planning.refinement.STEPS_DEG[:1])
    monkeypatch.setattr(validation.planning.refinement, "MOST_ROUNDS", 1)
    monkeypatch.setattr(validation.comparison.engine, "ProcessEngine", lambda jobs: SerialEngine())
    rng = np.random.default_rng(0)
    field = rng.standard_normal((300, 3))
    field *= 48.152 / np.linalg.norm(field, axis=1, keepdims=True)
    time_ms = 100.0 * np.arange(300)[:, None]
    mag = field * [1.1, 0.9, 1.0] + [3.0, -2.0, 5.0] + 0.01 * rng.standard_normal((300, 3))
    write(tmp_path / "log.csv", "t,bx,by,bz,wheel", np.hstack([time_ms, mag, time_ms]))
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    (tmp_path / "docs").symlink_to(ROOT / "docs")
    attitude = rng.standard_normal((300, 4))
    attitude /= np.linalg.norm(attitude, axis=1, keepdims=True)
    columns = "t,mx,my,mz,gx,gy,gz,att_qw,att_qx,att_qy,att_qz"
    write(tmp_path / "frd.csv", columns, np.hstack([time_ms, 10 * mag, mag, attitude]))
    return tmp_path


def write(path: Path, header: str, rows: np.ndarray) -> None:
    np.savetxt(path, rows, delimiter=",", header=header, comments="")


@pytest.mark.parametrize(
    "page", [pytest.param(page, marks=[pytest.mark.slow] * (page.stem in LONG), id=page.name) for page in PAGES]
)
def test_commands_and_snippets_run(page: Path, place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shown: list[Path] = []
    monkeypatch.setattr(magbench.viewer, "view", lambda file, **_: shown.append(file))
    for language, code in blocks(page):
        if language == "toml":
            (place / code.split("\n")[0].removeprefix("# ")).write_text(code, encoding="utf-8")
        elif language == "python":
            if named := MODULE.match(code):
                (place / named[1]).write_text(code, encoding="utf-8")
            run_snippet(code, page)
        elif language == "sh":
            for line in code.replace("\\\n", " ").splitlines():
                run_line(line)
    assert all(file.is_file() for file in shown)


def parsed(line: str) -> None:
    """Read a command's options, whose names are looked at before their values; files of an earlier command may lack."""
    _, name, *arguments = shlex.split(line)
    if ">" in arguments:
        arguments = arguments[: arguments.index(">")]
    try:
        with in_options():
            program().commands[name].make_context(name, arguments)
    except InputError as refused:
        if "no such file" not in str(refused):
            raise


def test_commands_have_the_options_that_the_pages_give_them() -> None:
    """Of every page, those that the nightly run follows too."""
    for page in PAGES:
        for line in shell_lines(page):
            if line.startswith("magbench "):
                parsed(line)
    with pytest.raises(TyperException, match="--knowlege"):
        parsed("magbench bound auv-spiral --knowlege vector")


def run_line(line: str) -> None:
    program, *arguments = shlex.split(line)
    assert program in ("magbench", "make", "cc"), f"a command that this test cannot check: {line}"
    if program == "cc":
        subprocess.run([program, *arguments], check=True)
    if program != "magbench":
        return
    if arguments[0] == "simulate" and "--jobs" not in arguments:
        arguments[1:1] = ["--jobs", "1"]  # a pool takes longer to start than these short runs
    if arguments[0] == "compare":
        arguments[arguments.index("--trials") + 1] = "10"
    if arguments[0] == "reproduce":
        assert arguments[1] in (*PAPERS, "all"), line
        arguments = ["reproduce", QUICKEST, *arguments[2:], "--seeds", "2", "--jobs", "1"]
    told = io.StringIO()
    with contextlib.redirect_stdout(told), contextlib.redirect_stderr(io.StringIO()) as complaints:
        arguments, target = (arguments[:-2], arguments[-1]) if ">" in arguments else (arguments, None)
        status = main(arguments)
    assert status == 0, f"{line}\n{complaints.getvalue()}"
    if target:
        Path(target).write_text(told.getvalue(), encoding="utf-8")


def run_snippet(code: str, page: Path) -> None:
    compiled = compile(code, page.name, "exec")
    if not any(f"import {name}" in code and importlib.util.find_spec(name) is None for name in NOT_OURS):
        with contextlib.redirect_stdout(io.StringIO()):
            exec(compiled, {"__name__": "snippet"})


def test_the_worked_example_is_an_effect_that_acts(monkeypatch: pytest.MonkeyPatch) -> None:
    ((_, code),) = [block for block in blocks(ROOT / "CONTRIBUTING.md") if block[0] == "python"]
    battery = ModuleType("battery")
    monkeypatch.setitem(sys.modules, "battery", battery)
    exec(compile(code, "battery.py", "exec"), battery.__dict__)
    effect, R_wb, none = battery.BatteryField, np.tile(np.eye(3), (3, 1, 1)), np.zeros((3, 3))
    charge = {battery.CHARGE: np.array([1.0, 0.5, 0.0])}
    state = State(np.arange(3.0), 1.0, none, R_wb, none, none[0], none, none, charge)
    rng = np.random.default_rng(0)
    expected = np.outer([0.0, 0.5, 1.0], effect.example["gain_nT"])
    np.testing.assert_allclose(effect(**effect.example).apply(state, none, rng, {}), expected)
    assert not effect().apply(state, none, rng, {}).any()


@pytest.mark.parametrize("page", [*PAGES, *OTHERS], ids=lambda page: page.name)
def test_links_and_pictures_exist(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    targets = [t for t in re.findall(r"\]\(([^)\s]+)\)", text) if "://" not in t]
    assert not [t for t in targets if not (page.parent / t.split("#")[0]).exists()]


def test_every_picture_is_shown_and_small() -> None:
    texts = "".join(page.read_text(encoding="utf-8") for page in PAGES)
    for picture in (ROOT / "docs" / "pictures").iterdir():
        assert f"pictures/{picture.name})" in texts, f"no page shows {picture.name}"
        assert picture.stat().st_size <= 200_000


def test_make_targets_exist() -> None:
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
    for page in [*PAGES, *OTHERS]:
        text = page.read_text(encoding="utf-8")
        named = re.findall(r"`make ([a-z-]+)", text) + re.findall(r"^make ([a-z-]+)", text, re.MULTILINE)
        assert set(named) <= targets, page.name


def test_scenarios_effects_and_files_named_exist() -> None:
    """`magbench run NAME` in the text, and paths of source files."""
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        named = re.findall(r"`magbench (?:run|simulate) ([\w-]+)", text)
        assert set(named) <= set(catalogue()), page.name
        files = re.findall(rf"`((?:{'|'.join((*ORDER, 'tests'))})/[\w/.]+\.(?:py|toml))`", text)
        assert not [file for file in files if not (ROOT / file).exists()], page.name


@pytest.mark.parametrize("page", PAGES[1:], ids=lambda page: page.name)
def test_tables_are_what_the_code_says(page: Path) -> None:
    """Not the other way round: what was added to the code waits for `make pictures`."""
    text = page.read_text(encoding="utf-8")
    assert not tables.stale(text, tables.fill(text, measured=False)), "run `make pictures`"


def test_every_method_of_the_peers_is_in_their_command_and_in_the_table() -> None:
    texts = {path.stem.removeprefix("with_"): path for path in (ROOT / "examples" / "peers").glob("with_*.py")}
    methods = {
        f"{package}-{name}" for package, path in texts.items() for name in re.findall(r'"(\w+)": \w', path.read_text())
    }
    told = re.findall(r"([\w-]+)=peers/bin/python", " ".join(peers.command()))
    assert set(told) == methods
    page = peers.PAGE.read_text(encoding="utf-8")
    assert not [name for name in methods if f"| `{name}` |" not in page]


def test_a_table_of_the_peers_is_made_where_their_python_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    page = "<!-- table: peers -->\n| kept |\n<!-- end -->\n"
    monkeypatch.setattr(peers, "compared", lambda: [("`ellipsoid`", "30", "0.1", "20", "0.05", "0 of 20")])
    monkeypatch.delenv(peers.VARIABLE, raising=False)
    assert tables.fill(page) == page
    monkeypatch.setenv(peers.VARIABLE, "python")
    assert "| `ellipsoid` | 30 |" in tables.fill(page)
    assert tables.fill(page, measured=False) == page


def test_the_vehicles_track_as_the_page_says() -> None:
    """The scenarios that take least; `make pictures` drives all."""
    text = (ROOT / "docs" / "vehicles.md").read_text(encoding="utf-8")
    rows = tables.tracking(("quad-calibration", "turntable-twelve-stops", "auv-comb")).splitlines()
    assert not [row for row in rows if row not in text], "run `make pictures`"


def test_a_row_that_changed_is_stale_and_one_that_was_added_is_not() -> None:
    page = "| a | one |\n| b | -2.5 |\nnames (a, b).\n"
    assert not tables.stale(page, "| a | one |\n| new | three |\n| b | -2.5 |\nnames (a, new, b).\n")
    assert tables.stale(page, "| a | one |\n| b | 2.5 |\nnames (a, b).\n") == ["| b | -2.5 |"]
    assert tables.stale(page, "| a | one |\nnames (a).\n") == ["| b | -2.5 |", "names (a, b)."]


def test_the_pages_hold_all_that_was_there_when_they_were_made() -> None:
    docs = {page.stem: page.read_text(encoding="utf-8") for page in PAGES}
    made = shown.kept()["names"]
    assert not [name for name in made["effects"] if f"| `{name}` |" not in docs["effects"]]
    assert not [name for name in made["calibrators"] if f"| `{name}` |" not in docs["calibrators"]]
    assert not [name for name in made["vehicles"] if f"`{name}`" not in docs["vehicles"]]
    assert re.findall(r"(\d+) effects", docs["README"]) == [str(len(made["effects"]))]
    assert re.findall(r"(\d+) (?:calibrators|methods)", docs["README"]) == [str(len(made["calibrators"]))]
    assert not [name for kind, names in made.items() for name in names if name not in shown.names()[kind]]


def test_the_pages_leave_nothing_out() -> None:
    docs = {page.stem: page.read_text(encoding="utf-8") for page in PAGES}
    assert not [key for key in Scenario.model_fields if not re.search(rf"[`\[]{key}[`\].]", docs["scenarios"])]
    assert not [form for form, kind in FORMATS.items() if f"| `{form}` | `{kind.file}` |" not in docs["measured"]]
    assert not [key for key in PAPERS if f"`{key}`" not in docs["reproduce"]]


def test_the_pictures_show_what_the_program_draws_today() -> None:
    now, made = shown.reports(), shown.kept()
    old = {name: shown.changed(parts, now.get(name, {})) for name, parts in made["reports"].items()}
    old |= {file: shown.changed(view["shows"], now[view["scenario"]]) for file, view in made["views"].items()}
    assert not {name: parts for name, parts in old.items() if parts}, "run `make pictures`"


def test_the_papers_page_shows_what_the_program_fits_today() -> None:
    now = reproduced.rms_nT(reproduced.FEW)
    assert not shown.changed(shown.kept()["reproduced"], now), "run `make pictures`"


def test_what_changes_is_told_from_what_is_added() -> None:
    old = {"line": [100, 2.0, 8021.0], "ellipsoid": ["ok", 8021.0]}
    assert not shown.changed(old, {"line": [100, 2.001, 8021.0], "ellipsoid": ["ok", 8021.0], "new": [1]})
    assert shown.changed(old, {"line": [100, 2.0, 8021.0], "ellipsoid": ["unobservable", 8021.0]}) == ["ellipsoid"]
    assert shown.changed(old, {"line": [50, 2.0, 8021.0]}) == ["line", "ellipsoid"]


def test_every_source_that_the_code_cites_is_in_the_references() -> None:
    known = set(re.findall(r"^\| (\w+) \|", (ROOT / "REFERENCES.md").read_text(encoding="utf-8"), re.MULTILINE))
    folders = (*ORDER, "tests")
    code = [path.read_text(encoding="utf-8") for folder in folders for path in (ROOT / folder).rglob("*.py")]
    cited = {key for text in code for found in KEY.findall(text) for key in found if key}
    assert {"Ding2021", "Markley1988"} <= cited
    assert not cited - known


def test_scores_and_columns_are_named_as_they_are(place: Path) -> None:
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        assert main(["simulate", "auv-spiral-excited", "-o", "out"]) == 0
        spec = sim.scenario.load("auv-spiral-excited")
    outcome = magbench.run_scenario(spec, place / "out")
    scores = (ROOT / "docs" / "scores.md").read_text(encoding="utf-8")
    told = set(re.findall(r"^\| `(\w+)` \|", scores, re.MULTILINE))
    assert told == {score.name for found in outcome.scores.values() for score in found}
    dataset = (ROOT / "docs" / "dataset.md").read_text(encoding="utf-8")
    rows = [line.split("|")[1] for line in dataset.splitlines() if line.startswith("| `")]
    names = {name for cell in rows for name in re.findall(r"`(\w+)`", cell)}
    assert names <= {column.name for column in read_manifest(place / "out").columns}
    assert {column.group for column in read_manifest(place / "out").columns} >= {"mag", "truth", "effect"}

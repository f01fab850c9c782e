"""How the command line starts: version, completion, and what is checked before anything heavy is imported."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

import magbench
from calib import CALIBRATORS
from magbench.arguments import calibrator_names, complete_calibrators, complete_paper, complete_scenario, paper_keys
from magbench.cli import main
from papers import PAPERS
from scenarios.load import catalogue
from scenarios.names import scenario_names

HEAVY = {"numpy", "scipy", "numba", "mujoco", "matplotlib", "pyarrow", "rerun"}
LOADED = "import sys\nfrom magbench.cli import main\nstatus = main(sys.argv[1:])\nprint('LOADED', status, *sys.modules)"


@pytest.mark.parametrize(
    ("arguments", "status", "told"),
    [
        ("--help", 0, "simulate"),
        ("--version", 0, magbench.__version__),
        ("calibrate --help", 0, "--field-strength-nT"),
        ("run auv-dvie", 2, "did you mean auv-dive"),
        ("simulate nowhere.toml", 2, "no such file, and no scenario of this name"),
        ("calibrate nowhere.csv", 2, "nowhere.csv: no such file"),
        ("calibrate . --with elipsoid", 2, "did you mean ellipsoid"),
        ("diagnose nowhere.csv", 2, "nowhere.csv: no such file"),
        ("diagnose . --model auv-dvie", 2, "did you mean auv-dive"),
        ("diagnose . --confirm nowhere.csv", 2, "nowhere.csv: no such file"),
        ("inspect nowhere.csv", 2, "nowhere.csv: no such file"),
        ("apply nowhere.json . -o a.csv", 2, "nowhere.json: no such file"),
        ("reproduce li2071", 2, "li2017"),
        ("show nowhere", 2, "there is no recording"),
    ],
)
def test_help_and_misspelt_names_are_answered_before_anything_heavy_is_imported(
    arguments: str, status: int, told: str
) -> None:
    command = [sys.executable, "-c", LOADED, *arguments.split()]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    last = done.stdout.splitlines()[-1].split()
    assert last[:2] == ["LOADED", str(status)]
    assert told in done.stdout + done.stderr
    assert not HEAVY & set(last)


def test_names_that_files_tell_are_those_that_there_are() -> None:
    """A calibrator's file, a paper's folder and a scenario's file have its name."""
    assert set(calibrator_names()) == set(CALIBRATORS)
    assert set(paper_keys()) == set(PAPERS)
    assert scenario_names() == list(catalogue())


@pytest.mark.parametrize(
    ("line", "offered", "left_out"),
    [
        ("magbench sim", "simulate", "calibrate"),
        ("magbench run auv-d", "auv-dive", "auv-comb"),
        ("magbench calibrate x --with sphere,ellipsoid_", "sphere,ellipsoid_segmented", "sphere,sphere"),
        ("magbench reproduce zh", "zhou2012", "li2017"),
        ("magbench list sc", "scenarios", "effects"),
    ],
)
def test_the_shell_completes(line: str, offered: str, left_out: str) -> None:
    words = {"_MAGBENCH_COMPLETE": "complete_bash", "COMP_WORDS": line, "COMP_CWORD": str(len(line.split()) - 1)}
    command = [sys.executable, "-m", "magbench"]
    done = subprocess.run(command, capture_output=True, text=True, env=os.environ | words, check=False)
    assert done.returncode == 0
    assert offered in done.stdout.split()
    assert left_out not in done.stdout.split()


def test_a_script_for_the_shell_is_shown(capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """Typer looks for the shell among the processes above, where a test run need not have one."""
    monkeypatch.setattr("shellingham.detect_shell", lambda: ("bash", "bash"))
    assert main(["--show-completion", "bash"]) == 0
    assert "_MAGBENCH_COMPLETE=complete_bash" in capfd.readouterr().out


def test_completion_offers_what_begins_so() -> None:
    assert complete_scenario("auv-spiral") == ["auv-spiral", "auv-spiral-excited"]
    assert complete_calibrators("") == calibrator_names()
    assert complete_calibrators("sphere,pso") == ["sphere,pso", "sphere,psoga"]
    assert complete_paper("") == [*paper_keys(), "all"]


def test_the_version_is_the_distributions(capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["--version"]) == 0
    assert capfd.readouterr().out == f"magbench {magbench.__version__}\n"
    text = Path(magbench.__file__).with_name("__init__.py").read_text(encoding="utf-8")
    assert f'__version__ = "{magbench.__version__}"' in text

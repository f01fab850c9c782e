"""What holds for every command: help with an example, one JSON object on standard output, exit status 0, 1 or 2."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path

import pytest

from magbench.app import program
from magbench.cli import main
from tests.magbench.test_bad_input import log
from tests.results import check_files, check_printed
from tests.validation.gates.conftest import gate_text
from validation.comparison.engine import SerialEngine

COMMANDS = sorted(program().commands)
STILL = "turntable-twelve-stops"

GOOD: dict[str, tuple[str, ...]] = {
    "apply": ("apply", "calibration.json", "log.csv", "-o", "corrected.csv"),
    "bound": ("bound", "log.csv", "--field-strength-nT", "34000"),
    "calibrate": ("calibrate", "log.csv", "--field-strength-nT", "34000", "-o", "out"),
    "compare": ("compare", STILL, "--trials", "1", "--with", "sphere", "-o", "out"),
    "diagnose": ("diagnose", "log.csv", "--field-strength-nT", "34000", "-o", "out"),
    "gate": ("gate", "gates.toml", "-o", "out"),
    "inspect": ("inspect", "log.csv", "-o", "out"),
    "list": ("list", "effects"),
    "plan": ("plan", "hand", "--time", "120", "--trials", "0", "-o", "out"),
    "read": ("read", "log.csv", "-o", "read.parquet"),
    "recheck": ("recheck", "calibration.json", "log.csv", "--field-strength-nT", "34000"),
    "reproduce": ("reproduce", "zhou2012", "--seeds", "2", "--jobs", "1", "-o", "out"),
    "run": ("run", STILL, "-o", "out"),
    "schema": ("schema", "gates"),
    "show": ("show", "recording.rrd"),
    "simulate": ("simulate", STILL, "-o", "out"),
}
"""A call of each command that is done in seconds."""

BAD: dict[str, tuple[str, ...]] = {
    "apply": ("apply", "nowhere.json", "log.csv", "-o", "corrected.csv"),
    "bound": ("bound", "nowhere"),
    "calibrate": ("calibrate", "nowhere.csv"),
    "compare": ("compare", STILL, "--sweep", "planet=1,2", "-o", "out"),
    "diagnose": ("diagnose", "nowhere.csv"),
    "gate": ("gate", "log.csv", "-o", "out"),
    "inspect": ("inspect", "nowhere.csv"),
    "list": ("list", "planets"),
    "plan": ("plan", "submarine", "-o", "out"),
    "read": ("read", "nowhere.bin"),
    "recheck": ("recheck", "nowhere.json", "log.csv"),
    "reproduce": ("reproduce", "nobody1900", "-o", "out"),
    "run": ("run", "nowhere.toml", "-o", "out"),
    "schema": ("schema", "of", "what"),
    "show": ("show", "nowhere.rrd"),
    "simulate": ("simulate", STILL, "-o", "log.csv"),
}
"""A call of each command with bad input."""


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A directory to work in, with a log, a calibration and a recording; no window of a viewer, no other process."""
    log(tmp_path / "log.csv")
    calibration = {"sphere": {"offset_nT": [0, 0, 0], "matrix": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}}
    (tmp_path / "calibration.json").write_text(json.dumps(calibration))
    (tmp_path / "recording.rrd").write_bytes(b"RRF2")
    (tmp_path / "gates.toml").write_text(gate_text("a", set=["phases.0.duration_s=40"], limit=1e4))
    monkeypatch.setattr("magbench.viewer.view", lambda file, web: None)
    monkeypatch.setattr("validation.comparison.engine.ProcessEngine", lambda jobs: SerialEngine())
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_every_command_is_tried() -> None:
    assert sorted(GOOD) == sorted(BAD) == COMMANDS


@pytest.mark.parametrize("command", COMMANDS)
def test_help_tells_what_it_does_and_every_option(command: str, capfd: pytest.CaptureFixture[str]) -> None:
    assert main([command, "--help"]) == 0
    told = capfd.readouterr().out
    assert "--json" in told
    for parameter in program().commands[command].params:
        assert parameter.name == "help" or parameter.help, f"{command}: {parameter.name} is not explained"


@pytest.mark.parametrize("command", COMMANDS)
def test_the_example_in_the_help_uses_options_that_there_are(command: str, capfd: pytest.CaptureFixture[str]) -> None:
    text = program().commands[command].help or ""
    found = re.search(r"Example: magbench (.*)", text)
    assert found, f"{command} has no example"
    example = shlex.split(found[1].split(" > ")[0])
    assert example[0] == command
    assert main([*example, "--help"]) == 0, capfd.readouterr().err


@pytest.mark.parametrize("command", COMMANDS)
def test_json_is_one_object_on_standard_output_as_its_schema_says_and_nothing_else(
    command: str, place: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    found_a_gap = {1} if command in ("diagnose", "recheck") else set()
    assert main([*GOOD[command], "--json"]) in {0} | found_a_gap, capfd.readouterr().err
    printed = json.loads(capfd.readouterr().out)
    assert isinstance(printed, dict)
    check_printed(GOOD[command], printed)
    check_files(place / "out")


@pytest.mark.usefixtures("place")
@pytest.mark.parametrize("option", [(), ("--json",)], ids=["text", "json"])
@pytest.mark.parametrize("command", COMMANDS)
def test_bad_input_is_one_line_status_2_and_nothing_on_standard_output(
    command: str, option: tuple[str, ...], capfd: pytest.CaptureFixture[str]
) -> None:
    assert main([*BAD[command], *option]) == 2
    told = capfd.readouterr()
    assert told.out == ""
    assert re.fullmatch(r"magbench: .+\n", told.err)


def test_without_a_command_the_commands_are_told(capfd: pytest.CaptureFixture[str]) -> None:
    assert main([]) == 0
    told = capfd.readouterr().out
    assert all(re.search(rf"^  {command} ", told, re.MULTILINE) for command in COMMANDS)
    assert "Exit status" in told

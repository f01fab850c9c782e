"""Whoever computes, and whatever is killed on the way, the table is the same to the byte."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from contextlib import closing
from pathlib import Path

import pytest

from reports.outputs.comparison import compare
from scenarios.errors import InputError
from sim.memory_run import run_in_memory
from sim.simulation import plan
from tests.conftest import ROOT
from tests.short import cuts
from tests.validation.comparison.breaking import killer
from tests.validation.comparison.conftest import small
from validation.comparison.design import Design
from validation.comparison.engine import ProcessEngine, SerialEngine, run_trials
from validation.comparison.journal import JOURNAL, Journal
from validation.comparison.trial_table import TRIALS

NUMBER = 6


def table(design: Design, out: Path, engine: SerialEngine | ProcessEngine, trials: int = NUMBER) -> bytes:
    compare(design, trials, out, engine)
    return (out / TRIALS).read_bytes()


@pytest.fixture(scope="module")
def expected(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    return table(small(), tmp_path_factory.mktemp("here"), SerialEngine())


def victim_nT(design: Design, run: int) -> float:
    recording, _ = run_in_memory(plan(design.points[0].scenario, run, design.seed))
    return float(recording.mag_nT[0, 0])


def test_processes_give_what_this_process_gives(design: Design, expected: bytes, tmp_path: Path) -> None:
    assert table(design, tmp_path / "2", ProcessEngine(2)) == expected


@pytest.mark.slow
def test_a_killed_worker_changes_nothing_and_a_deadly_trial_is_a_failed_one(design: Design, tmp_path: Path) -> None:
    field_nT = victim_nT(design, 1)
    once, always = (small(chosen=(killer(field_nT, file),)) for file in (str(tmp_path / "done"), ""))
    (tmp_path / "done").touch()
    whole = table(once, tmp_path / "here", SerialEngine(), 3)
    (tmp_path / "done").unlink()
    assert table(once, tmp_path / "killed", ProcessEngine(2), 3) == whole
    trials = list(run_trials(always, range(3), ProcessEngine(2)))
    failed = {(trial.point, trial.run) for trial in trials if trial.rows[0].status == "not_converged"}
    assert failed == {(0, 1)}
    assert len(trials) == 6
    (reason,) = {trial.rows[0].reason for trial in trials if trial.rows[0].status != "ok"}
    assert "was ended" in reason


def test_what_is_there_is_not_computed_again(design: Design, expected: bytes, tmp_path: Path) -> None:
    """More trials than before extend a comparison; fewer show a part of it."""
    table(design, tmp_path, SerialEngine(), 4)
    before = (tmp_path / JOURNAL).read_bytes()
    assert table(design, tmp_path, SerialEngine()) == expected
    assert (tmp_path / JOURNAL).read_bytes().startswith(before)
    whole = (tmp_path / JOURNAL).read_bytes()
    table(design, tmp_path, SerialEngine(), 2)
    assert table(design, tmp_path, SerialEngine()) == expected
    assert (tmp_path / JOURNAL).read_bytes() == whole


@pytest.mark.parametrize("damage", [lambda text: text[:-40], lambda text: text.replace(b'"run":1', b'"run":x', 1)])
def test_a_torn_or_damaged_line_is_computed_again(design: Design, expected: bytes, tmp_path: Path, damage) -> None:  # type: ignore[no-untyped-def]
    table(design, tmp_path, SerialEngine(), 3)
    (tmp_path / JOURNAL).write_bytes(damage((tmp_path / JOURNAL).read_bytes()))
    with closing(run_trials(design, range(3), SerialEngine(), Journal.open(tmp_path, design.identity()))) as trials:
        assert len(list(trials)) == 6
    assert table(design, tmp_path, SerialEngine()) == expected


@pytest.mark.slow
def test_a_killed_comparison_goes_on_where_it_was(expected: bytes, tmp_path: Path) -> None:
    sets = [word for text in cuts("turntable-twelve-stops") for word in ("--set", text)]
    command = [sys.executable, "-m", "magbench", "compare", "turntable-twelve-stops", *sets]
    command += ["--with", "sphere,ellipsoid", "--sweep", "noise_std_nT=5,50", "--seed", "5", "--jobs", "2"]
    command += ["--trials", str(NUMBER), "-o", str(tmp_path)]
    first = subprocess.Popen(command, cwd=ROOT, stderr=subprocess.DEVNULL)
    while first.poll() is None and _lines(tmp_path / JOURNAL) < 3:
        time.sleep(0.01)
    os.kill(first.pid, signal.SIGKILL)
    first.wait()
    assert not (tmp_path / TRIALS).exists()
    assert 0 < _lines(tmp_path / JOURNAL) - 1 < 2 * NUMBER
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True, timeout=120)
    assert (tmp_path / TRIALS).read_bytes() == expected


def _lines(path: Path) -> int:
    return path.read_bytes().count(b"\n") if path.exists() else 0


def test_another_comparison_in_the_same_place_is_refused(design: Design, tmp_path: Path) -> None:
    table(design, tmp_path, SerialEngine(), 1)
    with pytest.raises(InputError, match=r"holds another comparison: comparison\.calibrators"):
        table(small("ellipsoid"), tmp_path, SerialEngine(), 1)
    (tmp_path / JOURNAL).write_text("what\n")
    with pytest.raises(InputError, match="no journal"):
        table(design, tmp_path, SerialEngine(), 1)

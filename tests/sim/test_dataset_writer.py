"""Datasets survive being killed: the same command ends with the same hashes, and nothing is left over."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from magbench.cli import main
from recordings import read_manifest
from recordings.files import locked_directory
from scenarios.errors import InputError
from sim.dataset_writer import generate
from tests.short import cuts, short


def command(out: Path, runs: int, jobs: int = 1) -> list[str]:
    options = [text for cut in cuts("tumble") for text in ("--set", cut)]
    start = [sys.executable, "-m", "magbench", "simulate", "tumble", "-o", str(out), "--runs", str(runs)]
    return [*start, "--jobs", str(jobs), *options]


@pytest.mark.parametrize(("runs", "kills"), [(6, 1), pytest.param(40, 10, marks=pytest.mark.slow)])
def test_killed_and_restarted_ends_as_if_undisturbed(runs: int, kills: int, tmp_path: Path) -> None:
    generate(short("tumble"), tmp_path / "calm", runs=runs, jobs=1)
    rng = np.random.default_rng()
    for _ in range(kills):
        process = subprocess.Popen(command(tmp_path / "killed", runs), stderr=subprocess.DEVNULL)
        _wait_for_work(tmp_path / "killed", process)
        time.sleep(rng.uniform(0.0, 0.15))
        process.send_signal(signal.SIGKILL)
        process.wait()
    assert main(command(tmp_path / "killed", runs)[3:]) == 0
    calm, killed = (read_manifest(tmp_path / name) for name in ("calm", "killed"))
    assert killed.complete
    assert [file.sha256 for file in killed.files] == [file.sha256 for file in calm.files]
    names = {path.name for path in (tmp_path / "killed").iterdir()}
    assert names == {"dataset.json", *(file.path for file in calm.files)}


def _wait_for_work(out: Path, process: subprocess.Popen[bytes]) -> None:
    """Until the command has begun a run that was not there before, or has ended."""
    before = len(list(out.glob("run-*.parquet"))) if out.exists() else 0
    while process.poll() is None and len(list(out.glob("run-*"))) <= before:
        time.sleep(0.005)


@pytest.mark.parametrize(
    ("sent", "group"),
    [
        (signal.SIGINT, True),
        pytest.param(signal.SIGTERM, False, marks=pytest.mark.slow),
        pytest.param(signal.SIGINT, False, marks=pytest.mark.slow),
        pytest.param(signal.SIGTERM, True, marks=pytest.mark.slow),
        pytest.param(signal.SIGHUP, False, marks=pytest.mark.slow),
    ],
)
def test_interrupted_it_ends_at_once_with_one_line_and_resumes(
    sent: signal.Signals, group: bool, tmp_path: Path
) -> None:
    """The signal reaches the program alone, or its workers too; either way they stop, and nothing is half-written.

    Before, a second process that would write there is refused, and afterwards none is.
    """
    process = subprocess.Popen(
        command(tmp_path, 1000, jobs=2), stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    _wait_for_work(tmp_path, process)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="another magbench is writing here"):
        generate(short("tumble"), tmp_path, runs=1000)
    (os.killpg if group else os.kill)(process.pid, sent)
    _, told = process.communicate(timeout=30)
    assert process.returncode == 128 + sent
    assert [line for line in told.splitlines() if not line.startswith("simulating")] == [
        "magbench: interrupted; the same command resumes"
    ]
    with locked_directory(tmp_path):
        assert {path.suffix for path in tmp_path.iterdir()} <= {".json", ".parquet"}


def test_more_runs_keep_those_that_are_there(tmp_path: Path) -> None:
    generate(short("tumble"), tmp_path, runs=2)
    stamp = (tmp_path / "run-00001.parquet").stat().st_mtime_ns
    generate(short("tumble"), tmp_path, runs=3)
    assert (tmp_path / "run-00001.parquet").stat().st_mtime_ns == stamp
    assert len(read_manifest(tmp_path).files) == 3

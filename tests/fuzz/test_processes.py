"""The contract as a user meets it: whole processes, and two of them at once."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.fuzz.contract import check_answer, check_dataset, check_written, hold
from tests.fuzz.material import CALIBRATION, SCENARIO, log_table, scenario_in
from tests.fuzz.test_recordings import _write as write_table
from tests.fuzz.test_recordings import check as check_recording  # noqa: F401
from tests.nightly import first_daily

Cli = Callable[..., "subprocess.CompletedProcess[str]"]
WRONG = {
    "calibration": ("apply", "calibration.json", "log.parquet", "-o", "out/corrected.csv", "--with", "\udcff"),
    "scenario": ("simulate", "tiny.toml", "-o", "out", "--set", "seed=" + "[" * 5000),
    "recording": ("calibrate", "log.parquet", "-o", "out", "--field-strength-nT", "nan"),
}


@pytest.mark.parametrize("kind", first_daily(WRONG))
def test_wrong_use_as_a_process(kind: str, tmp_path: Path, cli: Cli) -> None:
    scenario_in(tmp_path)
    write_table(log_table(), tmp_path / "log.parquet", None)
    (tmp_path / "calibration.json").write_text(json.dumps(CALIBRATION))
    done = cli(*WRONG[kind], cwd=tmp_path)
    assert done.returncode == 2
    check_answer(2, done.stdout, done.stderr, done.stderr, as_json=False)
    check_written(tmp_path / "out")


def test_two_at_once_in_one_directory(tmp_path: Path) -> None:
    """However they meet, one is content or refused by the name of the other, and the dataset is whole."""
    scenario_in(tmp_path)
    command = [sys.executable, "-m", "magbench", "simulate", "tiny.toml", "-o", "out", "--runs", "3", "--jobs", "1"]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, "cwd": tmp_path}
    both = [subprocess.Popen(command, **pipes) for _ in range(2)]  # type: ignore[call-overload]
    for process in both:
        out, err = process.communicate(timeout=120)
        check_answer(process.returncode, out, err, err, as_json=False)
        assert process.returncode == 0 or "another magbench is writing" in err
    assert 0 in {process.returncode for process in both}
    check_dataset(tmp_path / "out")


def test_a_diagnosis_of_a_log_that_is_too_short(tmp_path: Path) -> None:
    write_table(log_table(), tmp_path / "log.parquet", None)
    arguments = ("diagnose", str(tmp_path / "log.parquet"), "--field-strength-nT", "44721", "-o", str(tmp_path / "out"))
    assert hold(tmp_path / "out", *arguments, "--json") == 2
    assert not (tmp_path / "out").exists()


def test_a_scenario_that_is_no_text(tmp_path: Path) -> None:
    for content in (b"\xff\xfe", b"\x00" * 4000, b"a = " + b"[" * 200_000, SCENARIO.encode()[:-1] + b"\xff"):
        (tmp_path / "tiny.toml").write_bytes(content)
        assert hold(tmp_path / "out", "simulate", str(tmp_path / "tiny.toml"), "-o", str(tmp_path / "out")) == 2

"""`magbench gate` on real trials, as a build runs it."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from magbench.cli import main
from tests.results import check_printed
from tests.validation.gates.conftest import gate_text
from validation.comparison.engine import SerialEngine
from validation.comparison.journal import JOURNAL

CUT = "phases.0.duration_s=40"


@pytest.fixture(autouse=True)
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A directory to work in; trials are computed in this process, since another takes longer to start than they do."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("validation.comparison.engine.ProcessEngine", lambda jobs: SerialEngine())


def written(*texts: str) -> str:
    Path("gates.toml").write_text("\n".join(texts))
    return "gates.toml"


def test_a_failed_gate_is_status_1_and_says_so_everywhere(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("GITHUB_ACTIONS", "true")
    file = written(gate_text("kept", set=[CUT], limit=1e4), gate_text("broken", set=[CUT], limit=1e-6))
    assert main(["gate", file, "-o", "out", "--json"]) == 1
    told = capfd.readouterr()
    found = json.loads(told.out)
    assert found["verdict"] == "fail"
    assert [(one["name"], one["verdict"]) for one in found["gates"]] == [("kept", "pass"), ("broken", "fail")]
    for one in found["gates"]:
        assert set(one) >= {"measured", "limit", "trials", "smallest_seen"}
        assert one["measured"] < one["smallest_seen"] or one["verdict"] == "fail"
    assert "::error file=gates.toml,title=gate broken::" in told.err
    assert "magbench: gate broken: fail" in told.err
    kept = json.loads(Path("out/gates.json").read_text())["gates"]
    assert [one["measured"] for one in kept] == [one["measured"] for one in found["gates"]]


def test_an_undecided_gate_is_a_warning_or_with_strict_status_1(capfd: pytest.CaptureFixture[str]) -> None:
    file = written(gate_text("kept", set=[CUT], limit=1e4, max_trials=21, power=0.99999999))
    command = ["gate", file, "-o", "out"]
    assert main(command) == 0
    assert "magbench: gate kept: inconclusive" in capfd.readouterr().err
    assert main([*command, "--strict"]) == 1


def test_a_baseline_is_written_and_kept(capfd: pytest.CaptureFixture[str]) -> None:
    file = written(gate_text("a", set=[CUT], baseline="base.parquet", max_trials=25))
    write = ["gate", file, "--write-baseline", "base.parquet"]
    assert main([*write, "--json"]) == 0
    check_printed(write, json.loads(capfd.readouterr().out))
    assert main(["gate", file, "-o", "out", "--json"]) == 0, capfd.readouterr().err
    (one,) = json.loads(capfd.readouterr().out)["gates"]
    assert (one["verdict"], one["measured"], one["limit"]) == ("pass", 1.0, 1.1)
    assert main(["gate", file, "--seed", "987", "-o", "out"]) == 2
    assert "holds nothing of seed 987" in capfd.readouterr().err


MINE = """
import numpy as np

def mine(recording, reference):
    mag = recording.mag_nT / reference.strength_nT
    found = np.linalg.lstsq(np.c_[2 * mag, np.ones(len(mag))], (mag**2).sum(1), rcond=None)[0]
    return reference.strength_nT * found[:3], np.eye(3)
"""
THEIRS = '{"offset_nT": [%s, 0, 0], "matrix": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}'


def test_calibrators_of_ones_own_are_compared_held_broken_and_caught(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """A numpy function by module:object, and a program in a directory of its own, from --init to the failure."""
    for painter in ("gates.gates_page", "comparison._record", "comparison.comparison_page"):
        monkeypatch.setattr(f"reports.outputs.{painter}", lambda *found: "")
    Path("my").mkdir()
    Path("my/own.py").write_text(MINE)
    Path("my/copy.sh").write_text('cp "$1" "$3"')
    Path("my/known.json").write_text(THEIRS % 100)
    program = "theirs:gyro=sh my/copy.sh my/known.json {recording.csv} {result}"
    words = ["--with", "ellipsoid,my.own:mine", "--exec", program, "--time-limit-s", "600", "--trials", "20"]
    assert main(["compare", "tumble", "--set", CUT, *words, "-o", "compared"]) == 0
    capfd.readouterr()
    begin = ["gate", "--init", "compared", "-o", "begun.toml"]
    assert main([*begin, "--json"]) == 0, capfd.readouterr().err
    check_printed(begin, json.loads(capfd.readouterr().out))
    text = Path("begun.toml").read_text()
    assert 'calibrator = "my.own:mine"' in text
    assert 'exec = "sh ./my/copy.sh ./my/known.json {recording.csv} {result}"' in text
    assert 'needs = ["gyro"]' in text
    assert "time_limit_s = 600.0" in text
    assert verdicts(capfd) == {"ellipsoid": "pass", "mine": "pass", "theirs": "pass"}
    Path("my/own.py").write_text(MINE.replace("* found[:3]", "* 10 * found[:3]"))
    Path("my/known.json").write_text(THEIRS % 1e6)
    assert verdicts(capfd) == {"ellipsoid": "pass", "mine": "fail", "theirs": "fail"}


def verdicts(capfd: pytest.CaptureFixture[str]) -> dict[str, str]:
    """Of the file that was begun, by the calibrator's name, and whether the exit status is that of the worst."""
    capfd.readouterr()
    status = main(["gate", "begun.toml", "-o", "out", "--json"])
    found = json.loads(capfd.readouterr().out)
    assert status == (found["verdict"] == "fail")
    return {one["name"].split()[0]: one["verdict"] for one in found["gates"]}


def test_a_program_that_hangs_costs_its_gate_the_time_limit_a_trial(capfd: pytest.CaptureFixture[str]) -> None:
    Path("hang.sh").write_text("sleep 100000\n")
    hanging = gate_text("hangs", "mine", set=[CUT], limit=1e4, exec="sh hang.sh {recording.csv} {result}")
    file = written("false_fail_rate = 0.4", hanging, gate_text("kept", set=[CUT], limit=1e4))
    assert main(["gate", file, "-o", "out", "--time-limit-s", "0.1", "--json"]) == 1
    hung, kept = json.loads(capfd.readouterr().out)["gates"]
    assert (hung["verdict"], kept["verdict"]) == ("fail", "pass")
    assert hung["without_estimate"] == hung["trials"]
    assert "stopped at the time limit" in hung["reason"]


@pytest.mark.slow
def test_a_killed_run_of_gates_goes_on_where_it_was() -> None:
    file = written(gate_text("kept", set=[CUT], limit=1e4), gate_text("near", "twostep", set=[CUT], limit=30.0))
    command = [sys.executable, "-m", "magbench", "gate", file, "--jobs", "1", "-o"]
    main(["gate", file, "-o", "whole"])
    killed = subprocess.Popen([*command, "out"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    journal = Path("out", JOURNAL)
    while killed.poll() is None and not (journal.exists() and journal.read_bytes().count(b"\n") > 3):
        time.sleep(0.002)
    os.kill(killed.pid, signal.SIGKILL)
    killed.wait()
    assert journal.exists()
    assert not Path("out/gates.json").exists()
    subprocess.run([*command, "out"], capture_output=True, timeout=300)
    for name in ("gates.json", "junit.xml", "summary.md"):
        assert Path("out", name).read_bytes() == Path("whole", name).read_bytes()
    assert not journal.exists()


def test_wrong_use_is_refused(capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["gate"]) == 2
    assert "no file of gates is named" in capfd.readouterr().err

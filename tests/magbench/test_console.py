"""Progress: percent that never goes back, inside a long run too, and lines that do not flood a log."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest

from magbench import console
from magbench.console import PlainLines
from reports.outputs.run import run_scenario
from sim.dataset_writer import generate
from tests.short import short


def test_plain_lines_come_at_the_start_at_the_end_and_ever_rarer_between(capsys: pytest.CaptureFixture[str]) -> None:
    now_s = [0.0]
    lines = PlainLines("working", lambda: now_s[0])
    for second in range(101):
        now_s[0] = float(second)
        lines(second / 100, 1)
    told = capsys.readouterr().err.splitlines()
    assert told[:2] == ["working: 0 %, 0 s", "working: 5 %, 5 s"]
    assert told[-1] == "working: 100 %, 100 s"
    seconds = [int(line.split(", ")[1].removesuffix(" s")) for line in told]
    apart = np.diff(seconds[:-1])
    assert apart.min() == 5
    assert (np.diff(apart) >= 0).all()
    assert len(told) < 15


def test_a_step_that_reports_nothing_tells_its_time(capsys: pytest.CaptureFixture[str]) -> None:
    now_s = [0.0]
    lines = PlainLines("inspecting flight.bin", lambda: now_s[0])
    for second in range(12):
        now_s[0] = float(second)
        lines.remind()
    assert capsys.readouterr().err.splitlines() == ["inspecting flight.bin: 5 s", "inspecting flight.bin: 10 s"]


def test_a_long_silence_is_broken(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(console, "PLAIN_INTERVAL_S", 0.05)
    with console.progress("waiting"):
        time.sleep(0.3)
    assert "waiting: 0 s" in capsys.readouterr().err.splitlines()


def test_a_long_run_tells_its_progress(tmp_path: Path) -> None:
    told: list[float] = []
    long = short("auv-spiral", "phases.0.duration_s=2000")
    generate(long, tmp_path, progress=lambda done, total: told.append(done / total))
    assert told == sorted(told)
    assert (told[0], told[-1]) == (0.0, 1.0)
    assert len([part for part in told if 0 < part < 1]) >= 4


@pytest.mark.slow
def test_a_dive_that_ends_early_jumps_ahead_and_never_back(tmp_path: Path) -> None:
    told: list[float] = []
    run_scenario(short("auv-dive"), tmp_path, progress=lambda done, total: told.append(done / total))
    assert told == sorted(told)
    assert (told[0], told[-1]) == (0.0, 1.0)

"""Progress: percent that never goes back, inside a long run too, and lines that do not flood a log."""

from __future__ import annotations

from pathlib import Path

import pytest

from magbench.console import PlainLines
from reports.outputs.run import run_scenario
from sim.dataset_writer import generate
from tests.short import short


def test_plain_lines_come_at_the_start_at_the_end_and_ten_seconds_apart(capsys: pytest.CaptureFixture[str]) -> None:
    clock = iter(range(1000))
    lines = PlainLines("working", lambda: float(next(clock)))
    for done in range(101):
        lines(done / 100, 1)
    told = capsys.readouterr().err.splitlines()
    assert told[0] == "working: 0 %"
    assert told[-1] == "working: 100 %"
    assert 8 <= len(told) <= 12


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

"""Damaged gate files, and journals of comparisons: one line, or what the whole file gives."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import pytest
from hypothesis import strategies as st

from scenarios.errors import InputError
from tests.fuzz.contract import amounts, fuzz, hold
from tests.fuzz.material import scenario_in
from tests.fuzz.tables import broken_bytes
from tests.fuzz.test_scenarios import VALUES
from tests.validation.gates.conftest import Scripted, row
from validation.comparison.engine import SerialEngine
from validation.comparison.journal import JOURNAL
from validation.gates.gate_file import load_gates

JOURNALS, GATES = 4, 60
"""Cases in the normal run."""
GATE = """false_fail_rate = 0.01

[[gate]]
name = "offset"
scenario = "tiny.toml"
calibrator = "sphere"
score = "offset_error_nT"
limit = 500.5
max_trials = 12
set = ["seed=2"]
"""
LINES = GATE.splitlines()
SCORE = 500.0
"""What every trial of a gate is told to have given."""


@pytest.fixture(autouse=True)
def serial(monkeypatch: pytest.MonkeyPatch) -> None:
    """Trials are computed in this process, since another takes longer to start than they do."""
    monkeypatch.setattr("validation.comparison.engine.ProcessEngine", lambda jobs: SerialEngine())


def compared(place: Path) -> int:
    command = ("compare", str(place / "tiny.toml"), "--with", "sphere,ellipsoid", "--trials", "3", "--jobs", "1")
    return hold(place / "checked by figures", *command, "-o", str(place / "out"), "--json")


def figures(place: Path) -> list[tuple[int, int, str]]:
    """The scores of every trial, without the times that a fit took."""
    kept = [json.loads(line) for line in (place / "out" / JOURNAL).read_text().splitlines()]
    times = ("wall_s", "cpu_s")
    return sorted(
        (one["point"], one["run"], str([{k: v for k, v in row.items() if k not in times} for row in one["rows"]]))
        for one in kept
        if "rows" in one
    )


@pytest.mark.slow
@amounts
def test_journals(tmp_path: Path, times: int) -> None:
    scenario_in(tmp_path)
    assert compared(tmp_path) == 0
    journal = tmp_path / "out" / JOURNAL
    whole, known = journal.read_bytes(), figures(tmp_path)

    def check(damage: Callable[[bytes], bytes]) -> None:
        journal.write_bytes(damage(whole))
        if compared(tmp_path) == 0:
            assert figures(tmp_path) == known
        else:
            shutil.rmtree(tmp_path / "out")
            (tmp_path / "out").mkdir()

    digits = st.tuples(st.integers(0, 10_000), st.sampled_from(b'0123456789e-. NI,"{')).map(
        lambda two: lambda data: data[: two[0] % len(data)] + bytes([two[1]]) + data[two[0] % len(data) + 1 :]
    )
    fuzz(broken_bytes.map(lambda one: one.to) | digits, check, JOURNALS, times)


@amounts
def test_gate_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, times: int) -> None:
    """Refused before any trial, or decided by scores told beforehand: nothing passes above its limit."""
    scenario_in(tmp_path)
    file, told = tmp_path / "gates.toml", [row("sphere", SCORE)]
    monkeypatch.setattr("validation.comparison.engine.ProcessEngine", lambda jobs: Scripted(lambda group, run: told))

    def check(case: tuple[tuple[int, str], ...]) -> None:
        lines = list(LINES)
        for at, value in case:
            key, equals, _ = lines[at % len(lines)].partition(" = ")
            lines[at % len(lines)] = f"{key} = {value}" if equals else value
        file.write_text("\n".join(lines))
        refused = is_refused(file)
        out = tmp_path / "out"
        shutil.rmtree(out, ignore_errors=True)
        status = hold(out, "gate", str(file), "-o", str(out), "--json")
        assert status == 2 or not refused
        if status != 2:
            decided = json.loads((out / "gates.json").read_text())["gates"]
            assert all(one["measured"] <= one["limit"] for one in decided if one["verdict"] == "pass")
            ElementTree.parse(out / "junit.xml")

    changes = st.tuples(st.integers(0, 20), st.sampled_from((*VALUES, "499.0", '"heading_rms_deg"', "500.1")))
    fuzz(st.lists(changes, min_size=1, max_size=3).map(tuple), check, GATES, times)


def is_refused(file: Path) -> bool:
    """Whether a gate file is refused, in one line."""
    try:
        load_gates(file)
    except InputError as error:
        return "\n" not in str(error) or pytest.fail(str(error))
    return False

"""Damaged scenarios given to the commands that simulate nothing to a file: bounds, comparisons, plans."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from tests.fuzz.contract import amounts, fuzz, hold
from tests.fuzz.test_scenarios import LINES, Case, cases, is_long
from validation.comparison.engine import SerialEngine

CASES = {"bound": 60, "compare": 15, "plan": 2}
"""Cases of each command in the normal run; a plan takes seconds, and is searched every night alone."""
WORDS: dict[str, tuple[str, ...]] = {
    "bound": ("bound", "FILE"),
    "compare": ("compare", "FILE", "--with", "sphere", "--trials", "1", "--jobs", "1"),
    "plan": ("plan", "turntable", "--like", "FILE", "--time", "30", "--trials", "0", "--jobs", "1"),
}


@pytest.fixture(autouse=True)
def serial(monkeypatch: pytest.MonkeyPatch) -> None:
    """Trials are computed in this process, since another takes longer to start than they do."""
    monkeypatch.setattr("validation.comparison.engine.ProcessEngine", lambda jobs: SerialEngine())


def check(place: Path, command: str, case: Case) -> int | None:
    """Write the scenario and give it to a command; a refusal leaves nothing. Long motions are left out."""
    out, file, text = place / "out", place / "tiny.toml", list(LINES)
    for at, line in case.lines:
        text[at] = line
    file.write_text("\n".join(text))
    if is_long(file, case.overrides):
        return None
    shutil.rmtree(out, ignore_errors=True)
    sets = [word for override in case.overrides for word in ("--set", override)]
    words = [str(file) if word == "FILE" else word for word in WORDS[command]]
    checked = out if command == "bound" else place / "scores may be missing"
    status = hold(checked, *words, *sets, "-o", str(out), "--json")
    assert status != 2 or not [path for path in out.rglob("*") if path.is_file()]
    return status


@amounts
@pytest.mark.parametrize("command", [pytest.param(name, marks=[pytest.mark.slow] * (name == "plan")) for name in WORDS])
def test_damaged_scenarios(command: str, tmp_path: Path, times: int) -> None:
    fuzz(cases(), lambda case: check(tmp_path, command, case), CASES[command], times)


@pytest.mark.parametrize(
    ("command", "override"),
    [
        ("bound", "effects.white_noise.std_nT=[0.0, 0.0, 0.0]"),
        ("bound", "field.enu_nT=[0.0, 0.0, 0.0]"),
        ("compare", "field.enu_nT=[0.0, 0.0, 0.0]"),
        ("plan", "field.enu_nT=[0.0, 0.0, 0.0]"),
        ("plan", "effects.white_noise.std_nT=[0.0, 0.0, 0.0]"),
    ],
)
def test_no_field_and_no_noise(command: str, override: str, tmp_path: Path) -> None:
    """Nothing to calibrate by, or no limit of accuracy: one line, and no matrix that cannot be inverted."""
    assert check(tmp_path, command, Case(overrides=(override,))) in (0, 2)

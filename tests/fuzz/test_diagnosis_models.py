"""Damaged models given to a diagnosis: refused in one line, with nothing written."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import strategies as st

from recordings import write_recording
from recordings.assemble import recording_of
from tests.fuzz.contract import amounts, asked, fuzz
from tests.fuzz.material import SCENARIO, measured
from tests.fuzz.test_scenarios import VALUES

CASES = 8
"""Cases in the normal run."""
LINES = SCENARIO.splitlines()


@pytest.fixture
def place(tmp_path: Path) -> Path:
    """A directory with a log that is too short to diagnose."""
    short = {name: column[:12] for name, column in measured().items()}
    write_recording(recording_of(short), tmp_path / "log.parquet")
    return tmp_path


@amounts
def test_models_to_diagnose_by(place: Path, times: int) -> None:
    """Of a log that is too short to diagnose: the model is read before, and whatever is refused is one line."""
    model, log = place / "model.toml", place / "log.parquet"

    def check(case: list[tuple[int, str]]) -> None:
        lines = list(LINES)
        for at, value in case:
            key, equals, _ = lines[at % len(lines)].partition(" = ")
            lines[at % len(lines)] = f"{key} = {value}" if equals else value
        model.write_text("\n".join(lines))
        assert asked(place, "diagnose", str(log), "--model", str(model)) == 2

    changes = st.tuples(st.integers(0, len(LINES)), st.sampled_from(VALUES))
    fuzz(st.lists(changes, min_size=1, max_size=3), check, CASES, times)

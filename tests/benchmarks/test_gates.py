"""Gates on real trials, in short: no sound calibrator fails, every sabotaged one does, clear cases are soon decided."""

from __future__ import annotations

import pytest

from benchmarks.gates import CLEAR_TRIALS, measured
from validation.comparison.engine import SerialEngine


@pytest.mark.slow
def test_sound_calibrators_pass_and_sabotaged_ones_fail_every_time() -> None:
    found = measured(trials=60, runs=200, engine=SerialEngine())
    assert {row.what: row.verdict for row in found if row.verdict != "holds"} == {}
    longest = max(int(row.note.split()[1]) for row in found if "sabotage" in row.what)
    assert longest <= CLEAR_TRIALS

"""The table holds what the trials told, in one order whatever the order in which they landed."""

from __future__ import annotations

import random
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from scenarios.errors import InputError
from validation.comparison.design import Design
from validation.comparison.trial import Trial, TrialRow
from validation.comparison.trial_table import TRIALS, TrialTable


def told(point: int, run: int, *, slow: float = 1.0) -> Trial:
    """A trial in which the ellipsoid fails in every third run, its error else 10 point + run, the sphere's 100."""
    good = TrialRow("sphere", "ok", "", {"offset_error_nT": 100.0, "heading_rms_deg": 1.0}, 0.1 * slow, 0.2 * slow)
    fails = run % 3 == 2
    error = {} if fails else {"offset_error_nT": 10.0 * point + run}
    other = TrialRow("ellipsoid", "unobservable" if fails else "ok", "level" if fails else "", error, slow, slow)
    return Trial(point, run, (good, other, replace(good, calibrator="uncorrected")))


TRIALS_TOLD = [told(point, run) for point in (0, 1) for run in range(7)]


@pytest.fixture
def table(design: Design) -> TrialTable:
    return TrialTable.of(design, TRIALS_TOLD)


def test_values_are_paired_by_run_and_infinite_where_there_is_none(table: TrialTable) -> None:
    inf = np.inf
    np.testing.assert_array_equal(table.values("offset_error", "ellipsoid", 1), [10, 11, inf, 13, 14, inf, 16])
    np.testing.assert_array_equal(table.values("offset_error_nT", "sphere"), np.full(7, 100.0))
    np.testing.assert_array_equal(table.values("heading_rms", "ellipsoid"), np.full(7, inf))
    np.testing.assert_array_equal(table.values("matrix_error", "sphere"), np.full(7, inf))
    np.testing.assert_array_equal(table.failed("ellipsoid"), [run % 3 == 2 for run in range(7)])
    np.testing.assert_array_equal(table.time_s("cpu_s", "sphere"), np.full(7, 0.2))
    assert table.texts("reason", "ellipsoid", 1)[2] == "level"


def test_what_it_holds(table: TrialTable) -> None:
    assert table.calibrators == ("sphere", "ellipsoid", "uncorrected")
    assert set(table.scores) == {"offset_error_nT", "heading_rms_deg"}
    assert table.points == {0: {"effects.white_noise.std_nT": 5.0}, 1: {"effects.white_noise.std_nT": 50.0}}
    np.testing.assert_array_equal(table.runs(1), np.arange(7))
    for call in (lambda: table.values("offset", "sphere"), lambda: table.values("offset_error", "spher")):
        with pytest.raises(InputError):
            call()


def test_bytes_depend_on_neither_order_nor_times(design: Design, tmp_path: Path) -> None:
    shuffled = [told(trial.point, trial.run, slow=2.0) for trial in TRIALS_TOLD]
    random.Random(1).shuffle(shuffled)
    files = []
    for name, trials in (("a", TRIALS_TOLD), ("b", shuffled)):
        (tmp_path / name).mkdir()
        TrialTable.of(design, trials).write(tmp_path / name)
        files.append((tmp_path / name / TRIALS).read_bytes())
    assert files[0] == files[1]


def test_written_and_read_again(table: TrialTable, tmp_path: Path) -> None:
    table.write(tmp_path)
    again = TrialTable.read(tmp_path)
    assert again.columns.equals(table.columns)
    np.testing.assert_array_equal(again.time_s("wall_s", "ellipsoid", 1), table.time_s("wall_s", "ellipsoid", 1))
    (tmp_path / "timings.parquet").unlink()
    assert np.isnan(TrialTable.read(tmp_path / TRIALS).time_s("wall_s", "sphere")).all()
    assert pq.read_schema(tmp_path / TRIALS).metadata is None


def test_another_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / TRIALS).write_bytes(b"no table")
    with pytest.raises(InputError, match=TRIALS):
        TrialTable.read(tmp_path)

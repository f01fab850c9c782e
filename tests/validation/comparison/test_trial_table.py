"""The table holds what the trials told, in one order whatever the order in which they landed."""

from __future__ import annotations

import contextlib
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


def test_what_is_asked_without_a_point_is_of_the_first(design: Design) -> None:
    table = TrialTable.of(design, [told(0, 0), told(0, 2), told(1, 5), told(1, 6), told(1, 7)])
    np.testing.assert_array_equal(table.runs(), [0, 2])
    np.testing.assert_array_equal(table.runs(1), [5, 6, 7])
    np.testing.assert_array_equal(table.values("offset_error", "ellipsoid"), [0.0, np.inf])
    np.testing.assert_array_equal(table.failed("ellipsoid"), [False, True])
    assert table.texts("status", "ellipsoid") == ["ok", "unobservable"]
    np.testing.assert_array_equal(table.time_s("wall_s", "ellipsoid"), [1.0, 1.0])
    assert len(table.time_s("wall_s", "sphere", 1)) == 3


def test_rows_are_in_the_order_of_points_runs_and_calibrators(design: Design) -> None:
    table = TrialTable.of(design, [told(1, 1), told(0, 4), told(0, 3), told(1, 0)])
    columns = table.columns.to_pydict()
    assert list(zip(columns["point"], columns["run"], strict=True))[::3] == [(0, 3), (0, 4), (1, 0), (1, 1)]
    assert columns["calibrator"] == ["sphere", "ellipsoid", "uncorrected"] * 4
    assert columns["seed"] == [5] * 12
    assert columns["effects.white_noise.std_nT"] == [5.0] * 6 + [50.0] * 6
    assert columns["reason"][1::3] == ["", "", "", ""]
    assert columns["heading_rms_deg"][:3] == [1.0, None, 1.0]
    assert table.candidates == ("sphere", "ellipsoid")
    assert table.swept == ("effects.white_noise.std_nT",)


def test_swept_words_and_truths_are_text(design: Design) -> None:
    key = design.swept[0]
    for values, texts in ((("calm", "rough"), ["calm", "rough"]), ((True, 2.0), ["True", "2.0"])):
        points = tuple(replace(point, values={key: v}) for point, v in zip(design.points, values, strict=True))
        table = TrialTable.of(replace(design, points=points), [told(0, 0), told(1, 0)])
        assert table.columns.column(key).to_pylist() == [word for word in texts for _ in range(3)]


def test_a_column_that_is_missing_is_named(table: TrialTable, tmp_path: Path) -> None:
    pq.write_table(table.columns.drop_columns(["status"]), tmp_path / TRIALS)
    with pytest.raises(InputError, match="there is no column status"):
        TrialTable.read(tmp_path)


def test_a_damaged_page_is_refused_and_never_read_as_other_figures(table: TrialTable, tmp_path: Path) -> None:
    table.write(tmp_path)
    whole, rows = (tmp_path / TRIALS).read_bytes(), pq.read_metadata(tmp_path / TRIALS).row_group(0)
    ends = [rows.column(k).data_page_offset for k in range(rows.num_columns)]
    for place in range(4, max(ends), 7):
        (tmp_path / TRIALS).write_bytes(whole[:place] + bytes([whole[place] ^ 8]) + whole[place + 1 :])
        with contextlib.suppress(InputError):
            assert TrialTable.read(tmp_path).columns.equals(table.columns)

"""A baseline that no score can have written is refused in one line."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from reports.outputs.gates import record_baseline
from scenarios.errors import InputError
from tests.validation.comparison.conftest import small
from validation.comparison.engine import SerialEngine
from validation.gates.score_baseline import check_place, read_baseline, rows_of

SCORE = "offset_error_nT"


def with_value(value: float) -> Callable[[pa.Table], pa.Table]:
    def changed(table: pa.Table) -> pa.Table:
        return table.set_column(6, "value", pa.array([value, *table["value"].to_pylist()[1:]], pa.float64()))

    return changed


def as_text(table: pa.Table) -> pa.Table:
    return table.set_column(6, "value", table["value"].cast(pa.string()))


def as_integers(table: pa.Table) -> pa.Table:
    return table.set_column(6, "value", pa.array(range(len(table)), pa.int64()))


def twice(table: pa.Table) -> pa.Table:
    return pa.concat_tables([table, table])


DAMAGES = {
    "NaN": with_value(float("nan")),
    "infinite": with_value(float("inf")),
    "negative": with_value(-3.0),
    "near overflow": with_value(1e308),
    "larger than any score": with_value(1.5e12),
    "text": as_text,
    "integers": as_integers,
    "twice": twice,
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_scores_that_no_trial_gives_are_refused(damage: str, tmp_path: Path) -> None:
    design, path = small(), tmp_path / "b.parquet"
    scores = [0.0, 0.3, np.inf, 2.0, 1e12]
    whole = rows_of(design, "sphere", SCORE, np.array(scores))
    pq.write_table(whole, path)
    assert read_baseline(path, design, "sphere", SCORE, 5).tolist() == scores
    pq.write_table(DAMAGES[damage](whole), path)
    with pytest.raises(InputError) as caught:
        read_baseline(path, design, "sphere", SCORE, 5)
    assert "\n" not in str(caught.value)


def test_a_missing_folder_is_refused_before_the_trials(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such directory"):
        record_baseline([], SerialEngine(), tmp_path / "not" / "there.parquet")


def test_a_baseline_goes_into_a_file_of_a_folder_that_is_there(tmp_path: Path) -> None:
    check_place(tmp_path / "b.parquet")
    with pytest.raises(InputError, match="is a directory"):
        check_place(tmp_path)
    with pytest.raises(InputError, match="no such file"):
        read_baseline(tmp_path / "b.parquet", small(), "sphere", SCORE, 5)

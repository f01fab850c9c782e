"""Trials read as columns are the trials that were kept, and the table of many is built without their objects."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from scenarios.errors import InputError
from validation.comparison import journal as journals
from validation.comparison.journal import Journal
from validation.comparison.sealed_lines import sealed
from validation.comparison.trial import Trial, TrialRow
from validation.comparison.trial_columns import SCHEMA, columns_in, columns_of, in_order

IDENTITY = {"seed": 1}
REASONS = ("", "it broke down", 'said "5 µT"\n and 😀')


def made(point: int, run: int) -> Trial:
    """A trial of three calibrators, the second without an estimate."""
    rng = np.random.default_rng([point, run])
    scores = {"offset_error_nT": rng.lognormal(), "heading_rms_deg": rng.uniform(1e-30, 1e30)}
    return Trial(
        point,
        run,
        tuple(
            TrialRow(f"c{k}", "ok" if k != 1 else "failed", REASONS[k], scores if k != 1 else {}, rng.uniform(), 0.0)
            for k in range(3)
        ),
    )


def trials_of(columns: list[dict[str, object]]) -> list[Trial]:
    """Return the trials of plain values, without the scores that are missing."""
    return [
        Trial(one["point"], one["run"], tuple(TrialRow(**(row | {"scores": given(row["scores"])})) for row in rows))
        for one in columns
        if isinstance(rows := one["rows"], list)
    ]


def given(scores: dict[str, float | None]) -> dict[str, float]:
    return {name: value for name, value in scores.items() if value is not None}


@pytest.mark.parametrize("block_bytes", [1, 3000, 8 << 20])
def test_columns_of_a_journal_are_its_trials_once_and_in_order(
    tmp_path: Path, block_bytes: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(journals, "BLOCK_BYTES", block_bytes)
    journal = Journal.open(tmp_path, IDENTITY)
    for point, run in ((1, 2), (0, 5), (0, 0), (1, 0), (0, 5), (0, 9)):
        journal.add(made(point, run))
    found = journal.columns(9)
    assert trials_of(found.to_pylist()) == [made(*key) for key in ((0, 0), (0, 5), (1, 0), (1, 2))]
    assert found.equals(in_order(columns_of(trial for trial in journal if trial.run < 9)))


def test_a_journal_without_trials_has_no_rows(tmp_path: Path) -> None:
    assert Journal.open(tmp_path, IDENTITY).columns(3).equals(SCHEMA.empty_table())


def test_a_line_damaged_while_the_journal_is_open_is_no_trial(tmp_path: Path) -> None:
    journal = Journal.open(tmp_path, IDENTITY)
    for run in range(3):
        journal.add(made(0, run))
    journal.path.write_bytes(journal.path.read_bytes().replace(b'"run":1', b'"run":7'))
    assert journal.columns(9)["run"].to_pylist() == [0, 2]


@pytest.mark.parametrize("text", ['{"point":0,"run":1,"rows":3}', '{"point":0.5,"run":1,"rows":[]}', "[1]"])
def test_a_line_that_is_no_trial_is_refused_in_one_line(text: str) -> None:
    with pytest.raises(InputError, match="no trial") as refused:
        columns_in(sealed(text))
    assert "\n" not in str(refused.value)

"""A journal's lines are read once; whatever happens to the file of what was read, the trials are those of the lines."""

from __future__ import annotations

import itertools
import os
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest

from scenarios.errors import InputError
from tests.validation.comparison.test_trial_columns import IDENTITY, made
from validation.comparison import journal as journals
from validation.comparison import kept_columns
from validation.comparison.journal import JOURNAL, Journal
from validation.comparison.kept_columns import KEPT_COLUMNS
from validation.comparison.trial_columns import columns_in, columns_of

RUNS, LOOKS = 12, (2, 5, 12)
"""Trials of the journal, and how many there were at each look."""


@pytest.fixture
def looked(tmp_path: Path) -> Path:
    """A directory whose journal was looked at three times."""
    journal = Journal.open(tmp_path, IDENTITY)
    for run in range(RUNS):
        journal.add(made(0, run))
        if run + 1 in LOOKS:
            journal.columns(RUNS)
    return tmp_path


@pytest.fixture
def lines_read(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """How many lines were read as text, by block."""
    found: list[int] = []

    def counted(lines: bytes) -> pa.Table:
        found.append(lines.count(b"\n"))
        return columns_in(lines)

    monkeypatch.setattr(journals, "columns_in", counted)
    return found


def opened(out: Path, runs: int = RUNS) -> tuple[pa.Table, list[str]]:
    """The trials below a number of runs, and what was said."""
    said: list[str] = []
    return Journal.open(out, IDENTITY, warn=said.append).columns(runs), said


def changed(path: Path, change: Callable[[bytes], bytes]) -> None:
    """Change a file later than it was written: a file system's clock may stand still for some milliseconds."""
    path.write_bytes(change(path.read_bytes()))
    os.utime(path, ns=(0, path.stat().st_mtime_ns + 10**9))


def whole(runs: int = RUNS) -> pa.Table:
    return columns_of(made(0, run) for run in range(runs))


def test_lines_are_read_once(looked: Path, lines_read: list[int]) -> None:
    """No line by a second process, one line after one more trial, and the figures are those of the lines."""
    assert opened(looked)[0].equals(whole())
    assert sum(lines_read) == 0
    Journal.open(looked, IDENTITY).add(made(0, RUNS))
    assert opened(looked, RUNS + 1)[0].equals(whole(RUNS + 1))
    assert opened(looked, RUNS + 1)[0].equals(whole(RUNS + 1))
    assert sum(lines_read) == 1
    assert list(Journal.open(looked, IDENTITY)) == [made(0, run) for run in range(RUNS + 1)]


def test_looking_costs_what_is_new(tmp_path: Path, lines_read: list[int]) -> None:
    journal = Journal.open(tmp_path, IDENTITY)
    sizes = []
    for run in range(RUNS):
        journal.add(made(0, run))
        for _ in range(3):
            assert journal.columns(RUNS).equals(whole(run + 1))
        sizes.append((tmp_path / KEPT_COLUMNS).stat().st_size)
    assert lines_read == [1] * RUNS
    assert max(np.diff(sizes)) < 1.1 * sizes[0]


def test_a_flipped_bit_of_the_kept_columns_changes_no_figure(looked: Path, lines_read: list[int]) -> None:
    kept = looked / KEPT_COLUMNS
    content = kept.read_bytes()
    rng = np.random.default_rng(3)
    for place, bit in zip(rng.integers(0, len(content), 60), rng.integers(0, 8, 60), strict=True):
        damaged = bytearray(content)
        damaged[place] ^= 1 << bit
        kept.write_bytes(damaged)
        lines_read.clear()
        assert opened(looked)[0].equals(whole())
        assert sum(lines_read) == RUNS  # the damage is noticed
        assert kept.stat().st_size < len(content)  # one part in place of three


def test_a_kill_while_columns_are_kept_costs_no_trial(looked: Path) -> None:
    """At any byte of the last part, and before its first."""
    kept = looked / KEPT_COLUMNS
    content = kept.read_bytes()
    for cut in np.linspace(0, len(content) - 1, 30).astype(int):
        kept.write_bytes(content[:cut])
        assert opened(looked) == (whole(), [])


@pytest.mark.parametrize("parts", [(1, 2), (0, 2), (0, 1, 1, 2), (1, 0, 2)])
def test_parts_that_are_missing_repeated_or_swapped_are_not_believed(looked: Path, parts: tuple[int, ...]) -> None:
    kept = looked / KEPT_COLUMNS
    begins = [*(found.start() for found in re.finditer(rb'\{"sha256"', kept.read_bytes())), None]
    pieces = [kept.read_bytes()[start:end] for start, end in itertools.pairwise(begins)]
    assert len(pieces) == len(LOOKS)
    kept.write_bytes(b"".join(pieces[number] for number in parts))
    assert opened(looked) == (whole(), [])


@pytest.mark.parametrize("cut", [1, 50, 400])
def test_a_torn_last_line_is_computed_again_and_told(looked: Path, lines_read: list[int], cut: int) -> None:
    Journal.open(looked, IDENTITY).add(made(0, RUNS))
    changed(looked / JOURNAL, lambda text: text[:-cut])
    found, said = opened(looked, RUNS + 1)
    assert found.equals(whole())
    assert "1 line" in said[0]
    assert sum(lines_read) == 0
    Journal.open(looked, IDENTITY).add(made(0, RUNS))
    assert opened(looked, RUNS + 1)[0].equals(whole(RUNS + 1))


@pytest.mark.parametrize("keeps", [0, 1, 4])
def test_a_shorter_journal_is_read_anew(looked: Path, keeps: int) -> None:
    """Trials that were removed from the journal are not brought back."""
    changed(looked / JOURNAL, lambda text: b"".join(text.splitlines(keepends=True)[: keeps + 1]))
    assert opened(looked) == (whole(keeps), [])
    Journal.open(looked, IDENTITY).add(made(0, RUNS))
    assert opened(looked)[0].equals(whole(keeps))


def test_a_figure_changed_by_hand_is_computed_again_and_told(looked: Path) -> None:
    changed(looked / JOURNAL, lambda text: text.replace(b'"run":2', b'"run":9'))
    found, said = opened(looked, RUNS)
    assert found["run"].to_pylist() == [0, 1, *range(3, RUNS)]
    assert "1 line" in said[0]


def test_a_line_damaged_after_it_was_read_changes_no_figure(looked: Path) -> None:
    """Neither without a trace in the file's time of change, nor before further lines."""
    path = looked / JOURNAL
    time_ns, text = path.stat().st_mtime_ns, path.read_bytes()
    path.write_bytes(text.replace(b'"run":2', b'"run":9'))
    os.utime(path, ns=(0, time_ns))
    assert opened(looked, RUNS + 1) == (whole(), [])
    Journal.open(looked, IDENTITY).add(made(0, RUNS))
    assert opened(looked, RUNS + 1) == (whole(RUNS + 1), [])


def test_the_journal_of_another_comparison_is_read_anew(looked: Path, tmp_path: Path) -> None:
    """Beside columns of as many bytes, or of fewer."""
    (tmp_path / "other").mkdir()
    other = Journal.open(tmp_path / "other", IDENTITY)
    for run in reversed(range(RUNS + 1)):
        other.add(made(0, run))
        (looked / JOURNAL).write_bytes(other.path.read_bytes())
        kept = (looked / KEPT_COLUMNS).read_bytes()
        assert opened(looked, RUNS + 1)[0]["run"].to_pylist() == list(range(run, RUNS + 1))
        (looked / KEPT_COLUMNS).write_bytes(kept)


def test_another_design_is_refused_or_begins_without_trials(looked: Path) -> None:
    before = {path.name: path.read_bytes() for path in looked.iterdir()}
    with pytest.raises(InputError, match="holds another comparison"):
        Journal.open(looked, {"seed": 2})
    assert {path.name: path.read_bytes() for path in looked.iterdir()} == before
    assert len(Journal.open(looked, {"seed": 2}, anew=True).columns(RUNS)) == 0


def test_columns_of_another_release_are_made_anew(looked: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As of a release before a further score."""
    older = kept_columns.SCHEMA.remove(0)
    monkeypatch.setattr(kept_columns, "SCHEMA", older)
    assert kept_columns.KeptColumns(looked / KEPT_COLUMNS).read(looked / JOURNAL)[0].equals(older.empty_table())
    monkeypatch.undo()
    assert opened(looked)[0].equals(whole())


def test_a_removed_journal_leaves_no_columns(looked: Path) -> None:
    Journal.open(looked, IDENTITY).remove()
    assert list(looked.iterdir()) == []

"""A journal whose lines are damaged: no damaged figure is kept, and what does not match is computed again and told."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from scenarios.errors import InputError
from validation.comparison.journal import JOURNAL, Journal
from validation.comparison.trial import Trial, TrialRow

IDENTITY = {"seed": 1}


def made(run: int) -> Trial:
    scores = {"offset_error_nT": 162.96 + run}
    return Trial(0, run, (TrialRow("sphere", "ok", "", scores, 0.1, 0.1),))


@pytest.fixture
def whole(tmp_path: Path) -> bytes:
    journal = Journal.open(tmp_path, IDENTITY)
    for run in range(4):
        journal.add(made(run))
    return (tmp_path / JOURNAL).read_bytes()


def reopened(tmp_path: Path, content: bytes) -> tuple[list[Trial], list[str]]:
    (tmp_path / JOURNAL).write_bytes(content)
    said: list[str] = []
    return list(Journal.open(tmp_path, IDENTITY, warn=said.append)), said


def test_a_flipped_bit_in_any_line_is_never_believed(tmp_path: Path, whole: bytes) -> None:
    first = whole.index(b"\n") + 1
    rng = np.random.default_rng(3)
    for place, bit in zip(rng.integers(first, len(whole), 300), rng.integers(0, 8, 300), strict=True):
        damaged = bytearray(whole)
        damaged[place] ^= 1 << bit
        kept, said = reopened(tmp_path, bytes(damaged))
        assert all(trial == made(trial.run) for trial in kept)
        assert len(kept) in (2, 3)
        assert len(said) == 1
        assert "computed again" in said[0]


def test_a_flipped_bit_in_the_first_line_is_refused_in_one_line(tmp_path: Path, whole: bytes) -> None:
    for place in range(whole.index(b"\n") + 1):
        damaged = bytearray(whole)
        damaged[place] ^= 4
        with pytest.raises(InputError):
            reopened(tmp_path, bytes(damaged))


def test_a_journal_without_checksums_is_computed_again_and_told(tmp_path: Path, whole: bytes) -> None:
    lines = [json.loads(line) for line in whole.splitlines()]
    old = "".join(json.dumps({key: one[key] for key in one if key != "sha256"}) + "\n" for one in lines)
    kept, said = reopened(tmp_path, old.encode())
    assert kept == []
    assert "4 lines" in said[0]
    assert reopened(tmp_path, (tmp_path / JOURNAL).read_bytes()) == ([], [])


@pytest.mark.parametrize("line", [b"[" * 100_000, b"", b"null", b'{"comparison": 3}', b"\xff\xfe"])
def test_a_first_line_of_something_else_is_refused(tmp_path: Path, line: bytes) -> None:
    with pytest.raises(InputError):
        reopened(tmp_path, line + b"\n")


def test_a_whole_journal_is_kept_as_it_is(tmp_path: Path, whole: bytes) -> None:
    kept, said = reopened(tmp_path, whole)
    assert kept == [made(run) for run in range(4)]
    assert said == []
    assert (tmp_path / JOURNAL).read_bytes() == whole

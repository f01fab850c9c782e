"""Bounds kept beside the trials: computed once, damaged lines again, and never those of another design."""

from __future__ import annotations

from pathlib import Path

import pytest

from validation.bound.ratio import LeastErrors
from validation.bound.runs import RunBounds
from validation.comparison.design import Design
from validation.comparison.kept_bounds import BOUNDS, KeptBounds

NORM = frozenset({"norm"})


@pytest.fixture
def computed(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """The runs whose bounds are computed, in order."""
    runs: list[int] = []
    of = RunBounds.of

    def watched(self: RunBounds, run: int) -> LeastErrors:
        runs.append(run)
        return of(self, run)

    monkeypatch.setattr(RunBounds, "of", watched)
    return runs


def test_only_bounds_of_new_runs_are_computed(design: Design, computed: list[int], tmp_path: Path) -> None:
    file = tmp_path / BOUNDS
    first = KeptBounds(file, design, NORM).of(0, [0, 1])
    again = KeptBounds(file, design, NORM).of(0, [0, 1, 2])
    assert computed == [0, 1, 2]
    assert again[:2] == first == [RunBounds(design.points[0].scenario, design.seed, NORM).of(run) for run in (0, 1)]
    assert first[0]


def test_a_damaged_or_torn_line_is_computed_again(design: Design, computed: list[int], tmp_path: Path) -> None:
    file = tmp_path / BOUNDS
    first = KeptBounds(file, design, NORM).of(1, [0, 1, 2])
    head, one, other, last = file.read_bytes().splitlines(keepends=True)
    place = one.index(b"norm")
    damaged = one[:place] + bytes([one[place] ^ 1]) + one[place + 1 :]
    file.write_bytes(head + damaged + other + last[:-9])
    computed.clear()
    assert KeptBounds(file, design, NORM).of(1, [0, 1, 2]) == first
    assert computed == [0, 2]
    assert KeptBounds(file, design, NORM).of(1, [0, 1, 2]) == first
    assert computed == [0, 2]


def test_bounds_of_other_knowledge_are_not_taken(design: Design, computed: list[int], tmp_path: Path) -> None:
    file = tmp_path / BOUNDS
    KeptBounds(file, design, NORM).of(0, [0])
    (found,) = KeptBounds(file, design, frozenset({"vector"})).of(0, [0])
    assert computed == [0, 0]
    assert {of for of, _ in found} == {"vector"}


def test_without_a_knowledge_nothing_is_known_and_no_file_is_written(design: Design, tmp_path: Path) -> None:
    assert KeptBounds(tmp_path / BOUNDS, design, frozenset()).of(0, [3, 4]) == [{}, {}]
    assert not (tmp_path / BOUNDS).exists()


def test_bounds_of_points_stand_side_by_side(design: Design, computed: list[int], tmp_path: Path) -> None:
    kept = KeptBounds(tmp_path / BOUNDS, design, NORM)
    (quiet,), (loud,) = kept.of(0, [0]), kept.of(1, [0])
    key = ("norm", "offset_error_nT")
    assert loud[key] == pytest.approx(10 * quiet[key])  # noises of 5 and 50 nT
    assert KeptBounds(tmp_path / BOUNDS, design, NORM).of(1, [0]) == [loud]
    assert computed == [0, 0]

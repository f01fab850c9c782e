"""Runs are dealt out by their shares, and stay where they are when more are made."""

from __future__ import annotations

import numpy as np
import pytest

from recordings.split import PARTS, Split, split_from
from scenarios.errors import InputError

SHARES = [(80, 10, 10), (70, 20, 10), (34, 33, 33), (98, 1, 1), (50, 0, 50), (100, 0, 0), (0, 99, 1), (61, 23, 16)]


@pytest.mark.parametrize("shares", SHARES, ids=str)
def test_every_part_has_its_share_to_less_than_one_run_at_every_number_of_runs(shares: tuple[int, int, int]) -> None:
    for seed in range(3):
        split = Split(*shares, seed)
        parts = np.array([PARTS.index(split.part_of(run)) for run in range(350)])
        held = np.cumsum(parts[:, None] == np.arange(3), axis=0)
        due = np.outer(np.arange(1, 351), shares) / 100
        assert np.abs(held - due).max() < 1


def test_counts_are_those_of_the_runs_and_a_larger_dataset_keeps_every_run() -> None:
    split = Split(80, 10, 10, 5)
    few, many = ([split.part_of(run) for run in range(runs)] for runs in (37, 1000))
    assert many[:37] == few
    assert split.counts(37) == {part: few.count(part) for part in PARTS}
    assert split.counts(1000) == {"train": 800, "validation": 100, "test": 100}


def test_the_seed_decides_the_order() -> None:
    orders = {tuple(Split(80, 10, 10, seed).part_of(run) for run in range(10)) for seed in range(20)}
    assert len(orders) > 5


@pytest.mark.parametrize("text", ["80/10", "80/10/10/0", "80,10,10", "81/10/10", "80/20", "-10/100/10", "a/b/c", ""])
def test_what_is_no_split_is_refused(text: str) -> None:
    with pytest.raises(InputError, match=r"--split: .* is not three shares of 100 per cent \(give train/validation/t"):
        split_from(text, 0)


def test_shares_are_read_as_written() -> None:
    assert split_from(" 80/15/5 ", 9) == Split(80, 15, 5, 9)

"""Sums over blocks give the same fit, squares and block means as the whole columns."""

from __future__ import annotations

import numpy as np
import pytest

from sim.effects import EFFECTS
from validation.diagnosis.evidence.battery import battery
from validation.diagnosis.evidence.blocks import Cut, block_sums, fit, squares, sums


def test_fit_and_squares_equal_dense_least_squares() -> None:
    rng = np.random.default_rng(0)
    n, q, k = 1200, 3, 2
    base, columns, target = rng.normal(size=(n, 4)), rng.normal(size=(n, q, k)), rng.normal(size=(n, q))
    cut = Cut(10, 120)
    s = sums(cut, base, columns, target, np.ones(n))
    train = ~cut.held(1)
    f = fit(s, train)
    rows = np.repeat(train, cut.length)
    dense = np.concatenate(
        [np.kron(base[:, None, :], np.eye(q)).reshape(n * q, 4 * q), columns.reshape(n * q, k)], axis=1
    )
    use = np.repeat(rows, q)
    beta = np.linalg.lstsq(dense[use], target.ravel()[use], rcond=None)[0]
    left = target - base @ f.beta - columns @ f.c
    assert f.c == pytest.approx(beta[-k:])
    assert squares(s, f, ~train) == pytest.approx(float((left[~rows] ** 2).sum()))
    assert block_sums(s, f) == pytest.approx(left.reshape(120, 10, q).sum(axis=1))


def test_held_out_and_training_blocks_are_apart_and_go_round() -> None:
    cut = Cut(10, 200)
    held = np.array([cut.held(split) for split in range(5)])
    assert (held.sum(axis=0) == 2).all()


def test_white_noise_is_clean_and_a_slow_wave_is_not() -> None:
    rng = np.random.default_rng(1)
    failures = sum(not battery(rng.normal(size=(20_000, 3)), np.ones(20_000), 0.02, 12).clean for _ in range(40))
    assert failures <= 1
    wave = 0.1 * np.sin(2 * np.pi * 0.02 * 0.02 * np.arange(20_000))[:, None]
    assert not battery(rng.normal(size=(20_000, 3)) + wave, np.ones(20_000), 0.02, 12).clean


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda e: e.name)
def test_what_an_effect_offers_to_search_are_values_it_takes(effect) -> None:  # type: ignore[no-untyped-def]
    for name, values in (effect.search | effect.tangents).items():
        for value in values:
            assert getattr(effect(**{name: value}), name) == value

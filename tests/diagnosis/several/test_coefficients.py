"""Coefficients of several recordings: pooled, foretold by the others, held against each other, against simulation."""

from __future__ import annotations

import numpy as np
import pytest

from diagnosis.several.coefficients import (
    CoefficientEstimate,
    agreement,
    cross_predicted_gains,
    predicted_by_others,
    with_scatter,
)

TRUE = np.array([2.0, -1.0, 0.5])
SIZES = np.array([1.0, 1e3, 1e-4])
"""Units of the coefficients: the answer must not depend on them."""


def drawn(rng: np.random.Generator, c: np.ndarray, n: int = 40) -> tuple[CoefficientEstimate, np.ndarray, np.ndarray]:
    """An estimate from n samples of unit noise, with its design and target."""
    X = rng.normal(size=(n, len(c))) @ np.array([[1.0, 0.6, 0.0], [0.0, 1.0, 0.3], [0.0, 0.0, 1.0]]) / SIZES
    y = X @ (c * SIZES) + rng.normal(size=n)
    return CoefficientEstimate(X.T @ X, X.T @ y), X, y


def test_pooled_coefficients_are_those_of_all_samples_in_one_fit() -> None:
    rng = np.random.default_rng(0)
    several, X, y = zip(*(drawn(rng, TRUE) for _ in range(3)), strict=True)
    whole = np.linalg.lstsq(np.vstack(X), np.concatenate(y), rcond=None)[0]
    assert agreement(several, 0.0).c == pytest.approx(whole, rel=1e-9)
    others = np.linalg.lstsq(np.vstack(X[1:]), np.concatenate(y[1:]), rcond=None)[0]
    assert predicted_by_others(several)[0] == pytest.approx(others, rel=1e-9)
    left = (y[0] ** 2).sum() / 2 - ((y[0] - X[0] @ others) ** 2).sum() / 2
    assert cross_predicted_gains(several)[0] == pytest.approx(left, rel=1e-9)


def test_equal_coefficients_differ_at_the_rate_that_is_stated() -> None:
    rng = np.random.default_rng(1)
    p = [agreement([drawn(rng, TRUE)[0] for _ in range(3)], 0.0).p for _ in range(600)]
    for level in (0.5, 0.1, 0.05):
        assert np.mean(np.array(p) < level) == pytest.approx(level, abs=3.5 * np.sqrt(level * (1 - level) / 600))


def test_an_error_of_form_is_no_difference_and_a_third_more_is_one() -> None:
    rng = np.random.default_rng(2)
    strong = 100 * TRUE

    def p(last: np.ndarray, form: float) -> float:
        return agreement([drawn(rng, c, 400)[0] for c in (strong, strong, last)], form).p

    assert p(1.03 * strong, 0.0) < 1e-3 < p(1.03 * strong, 0.05)
    assert p(1.3 * strong, 0.05) < 0.01


def test_what_a_recording_leaves_open_is_neither_a_difference_nor_a_forecast() -> None:
    """Columns that vanish in one recording: it says nothing of them, and agrees with whatever the others say."""
    rng = np.random.default_rng(3)
    first, second = drawn(rng, TRUE)[0], drawn(rng, TRUE)[0]
    x = rng.normal(size=(40, 3)) * [1.0, 0.0, 0.0]
    third = CoefficientEstimate(x.T @ x, x.T @ (x @ TRUE + rng.normal(size=40)))
    seen = agreement([first, second, third], 0.0)
    assert seen.degrees == 4
    assert seen.p > 1e-3
    assert np.isfinite(seen.covariance).all()


def test_noise_foretells_nothing() -> None:
    """The others' coefficients lose on average half a column a recording where nothing is there."""
    rng = np.random.default_rng(4)
    nats = [cross_predicted_gains([drawn(rng, 0 * TRUE)[0] for _ in range(3)]).sum() for _ in range(300)]
    assert np.mean(nats) == pytest.approx(-9 / 4, abs=0.4)
    assert np.mean(np.array(nats) > np.log(29 / 0.001)) == 0.0


def test_what_scatters_within_a_recording_may_differ_between_them() -> None:
    """A coefficient that wanders from part to part: the stated error is a third of the true one."""
    rng = np.random.default_rng(5)

    def parts(m: int = 6, n: int = 30) -> list[CoefficientEstimate]:
        found = []
        for wander in 0.5 * rng.normal(size=m):
            X = rng.normal(size=(n, 2))
            y = X @ np.array([1.0 + wander, -2.0]) + rng.normal(size=n)
            found.append(CoefficientEstimate(X.T @ X, X.T @ y))
        return found

    stated, shown = [], []
    for _ in range(300):
        several = [parts() for _ in range(3)]
        whole = [CoefficientEstimate(sum(one.N for one in each), sum(one.g for one in each)) for each in several]  # type: ignore[arg-type]
        stated.append(agreement(whole, 0.0).p)
        shown.append(agreement(with_scatter(several, [1.0] * 3), 0.0, known=15).p)
    assert np.mean(np.array(stated) < 0.05) > 0.4
    assert np.mean(np.array(shown) < 0.05) < 0.08
    assert np.mean(np.array(shown) < 0.5) > 0.2

"""Coefficients of several recordings: pooled, foretold by the others, held against each other, against simulation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2, f

from diagnosis.several.coefficients import (
    CoefficientEstimate,
    agreement,
    cross_predicted_gain,
    inverse,
    predicted_by_others,
    rank,
    size_ratios,
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
    assert predicted_by_others(dict(enumerate(several)))[0] == pytest.approx(others, rel=1e-9)
    left = 0.0
    for i in range(3):
        rest = [j for j in range(3) if j != i]
        c = np.linalg.lstsq(np.vstack([X[j] for j in rest]), np.concatenate([y[j] for j in rest]), rcond=None)[0]
        left += (y[i] ** 2).sum() / 2 - ((y[i] - X[i] @ c) ** 2).sum() / 2
    assert cross_predicted_gain(several) == pytest.approx(left, rel=1e-9)


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
    nats = [cross_predicted_gain([drawn(rng, 0 * TRUE)[0] for _ in range(3)]) for _ in range(300)]
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


@pytest.mark.parametrize("unit", [1.0, 1e4])
def test_the_best_factor_of_given_coefficients_is_that_of_a_fit_of_their_course(unit: float) -> None:
    """One column ``X c``, whose error is one over the root of its squares, in any unit of the coefficients."""
    rng = np.random.default_rng(6)
    X, c = unit * rng.normal(size=(50, 2)) / 1e3, np.array([2.0, -1.0]) / unit
    y = 1.3 * X @ c + 1e-4 * rng.normal(size=50)
    own, others = CoefficientEstimate(X.T @ X, X.T @ y), CoefficientEstimate(X.T @ X, X.T @ X @ c)
    found, course = size_ratios({3: own, 5: others})[3], X @ c
    assert found[0] == pytest.approx(course @ y / (course @ course))
    assert found[1] == pytest.approx((course @ course) ** -0.5)
    wide = replace(own, wider=9.0 * np.linalg.inv(X.T @ X))
    assert size_ratios({0: wide, 1: others})[0] == pytest.approx((found[0], 3.0 * found[1]))


@pytest.mark.parametrize(
    ("along", "ratio"),
    [((13.0, 0.0), 1.3), ((7.5, 6.6), 0.75), ((6.5, 7.6), None), ((5.0, 12.0), None), ((-10.0, 0.0), None)],
)
def test_a_size_is_held_against_the_others_where_its_course_is_theirs(
    along: tuple[float, float], ratio: float | None
) -> None:
    """More than half of what it explains goes along the others' coefficients."""
    first, second = (CoefficientEstimate(np.diag([10.0, 10.0]), np.array(g)) for g in ((10.0, 0.0), along))
    found = size_ratios({0: first, 2: second}).get(2)
    assert (None if found is None else round(found[0], 9)) == ratio
    assert size_ratios({1: first}) == {}


def test_one_recording_agrees_with_itself() -> None:
    """No degree of freedom is left for a difference."""
    one = drawn(np.random.default_rng(7), TRUE)[0]
    found = agreement([one], 0.0)
    assert (found.degrees, found.p) == (0, 1.0)
    assert found.c == pytest.approx(one.c)
    assert found.covariance == pytest.approx(np.linalg.inv(one.N), rel=1e-6)
    assert predicted_by_others({0: one})[0].tolist() == [0.0, 0.0, 0.0]


def test_the_inflation_is_the_variance_along_coefficients_over_the_stated_one() -> None:
    """Of the course ``X c``; a covariance below the stated one, or no course, inflates nothing."""
    X, c = np.random.default_rng(8).normal(size=(40, 2)), np.array([1.0, 2.0])
    N = X.T @ X
    one = CoefficientEstimate(N, X.T @ X @ c)
    assert (one.inflation(c), one.covariance) == (pytest.approx(1.0), pytest.approx(np.linalg.inv(N)))
    wide = replace(one, wider=4.0 * np.linalg.inv(N))
    assert wide.inflation(c) == pytest.approx(4.0)
    assert replace(one, wider=0.25 * np.linalg.inv(N)).inflation(c) == 1.0
    assert wide.inflation(0.0 * c) == 1.0
    uneven = replace(one, wider=np.linalg.inv(N) + 3.0 * np.outer(c, c) / (c @ N @ c))
    assert uneven.inflation(c) == pytest.approx(4.0)


def test_the_rank_counts_what_is_determined_in_any_unit() -> None:
    rng = np.random.default_rng(9)
    X = rng.normal(size=(20, 3)) * SIZES
    for columns, found in ((X, 3), (X[:, [0, 1, 0]], 2), (X * [1.0, 0.0, 0.0], 1), (0 * X, 0), (1e-30 * X, 3)):
        assert rank(columns.T @ columns) == found
    N = X.T @ X
    assert inverse(N) @ N == pytest.approx(np.eye(3), abs=1e-6)
    half = np.diag([4.0, 0.0])
    assert inverse(half) == pytest.approx(np.diag([0.25, 0.0]))


def test_a_scatter_of_the_parts_widens_and_none_does_not_narrow() -> None:
    """Of two parts that are one apart, one column each: the squares of ``u`` sum to ``m / (m - 1)`` times theirs."""
    N = np.array([[4.0]])
    apart = [CoefficientEstimate(N, N @ [c]) for c in (1.0, 3.0)]  # 2 +- 1, each known to 1/2
    same = [CoefficientEstimate(N, N @ [2.0])] * 2
    one, other = with_scatter([apart, same], [1.0, 1.5])
    # u = 8^-1/2 (4 c - 4 2) is -4/sqrt 8 and its opposite: 4 in sum, twice that, over two recordings
    assert one.covariance == pytest.approx(4.0 / 8.0) == pytest.approx(other.covariance)
    (still,) = with_scatter([same], [1.5])
    assert still.covariance == pytest.approx(1.5 / 8.0)


def test_pooled_coefficients_are_as_certain_as_the_errors_of_the_recordings_allow() -> None:
    """One of twice the information and nine times the stated variance: ``(4 + 2 * 9) / 6^2`` over the unit."""
    several = [
        CoefficientEstimate(np.array([[4.0]]), np.array([4.0])),
        CoefficientEstimate(np.array([[2.0]]), np.array([2.0]), np.array([[4.5]])),
    ]
    assert agreement(several, 0.0).covariance == pytest.approx((4.0 + 2.0 * 9.0) / 6.0**2)


def test_coefficients_that_differ_are_pooled_with_the_error_of_their_scatter() -> None:
    """Two of one column, known to 1/2 each and 3 apart: Q = 2 (1.5 / 0.5)^2, 18 times the variance of the mean."""
    apart = [CoefficientEstimate(np.array([[4.0]]), np.array([4.0 * c])) for c in (1.0, 4.0)]
    found = agreement(apart, 0.0)
    assert (found.c, found.degrees) == (pytest.approx(2.5), 1)
    assert found.chi2 == pytest.approx(18.0)
    assert found.covariance == pytest.approx(18.0 / 8.0)
    assert found.p == pytest.approx(chi2.sf(18.0, 1))
    assert agreement(apart, 0.0, known=6).p == pytest.approx(f.sf(18.0, 1, 6))
    # an error of form of a half of 2.5 in each adds 1.25^2 to 1/4
    lenient = agreement(apart, 0.5)
    assert lenient.chi2 == pytest.approx(2 * 1.5**2 / (0.25 + 1.25**2))
    assert lenient.covariance == pytest.approx(18.0 / 8.0)  # without the error of form

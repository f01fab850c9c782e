"""Intervals and tests against simulation, published tables and brute force."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy.special import beta
from scipy.stats import binom, chi2

from validation.comparison.sequential_evidence import (
    excluded_ranks,
    log_evidence,
    log_evidence_of_bias,
    sequential_p,
)
from validation.comparison.statistics import (
    differences,
    holm_corrected,
    mean_ranks,
    mean_square,
    median,
    rate,
    width_ratio,
)

REPEATS = 4000
RNG = np.random.default_rng(7)


def coverage(intervals: list, truth: float) -> float:
    return float(np.mean([found.low <= truth <= found.high for found in intervals]))


@pytest.mark.parametrize("n", [8, 20, 50, 101])
@pytest.mark.parametrize(
    "draw", [RNG.normal, RNG.lognormal, RNG.standard_cauchy], ids=["normal", "log-normal", "Cauchy"]
)
def test_the_interval_of_the_median_holds_it_in_95_of_100(n, draw):
    """At one look of many it holds more often; below eight values it is the range."""
    data = draw(size=(REPEATS, n))
    truth = 1.0 if draw.__name__ == "lognormal" else 0.0
    assert coverage([median(row) for row in data], truth) > 0.95


def test_the_interval_of_the_median_holds_it_at_ten_looks_together():
    missed = sum(
        any(not found.low <= 0.0 <= found.high for found in (median(row[:n]) for n in range(50, 501, 50)))
        for row in RNG.normal(size=(400, 500))
    )
    assert missed / 400 < 0.05


def test_a_median_is_as_wide_as_stated_beside_a_number_fixed_in_advance():
    """z = sqrt(ln(800 n / pi)) of a uniform mixture [Howard2021] over 1.96: 1.63 at n = 100, 1.80 at 1000."""
    for n in (100, 1000):
        normal = np.sqrt(2 * np.log(20) + np.log(2 * n / np.pi)) / 1.96
        assert width_ratio(n) == pytest.approx(normal, rel=0.05)


def test_up_to_three_values_have_the_range_at_one_look_too() -> None:
    assert [width_ratio(n) for n in (1, 2, 3)] == [1.0, 1.0, 1.0]
    assert width_ratio(4) == pytest.approx(4 / (1.96 * 2), rel=1e-4)


def test_looking_ten_times_under_no_difference_says_clear_in_five_of_a_hundred_comparisons_at_most():
    wrong = 0
    for _ in range(300):
        one, other = RNG.lognormal(size=(2, 500))
        looks = (differences({"one": one[:n], "other": other[:n]}) for n in range(50, 501, 50))
        wrong += any(found.clear for (found,) in looks)
    assert wrong / 300 < 0.05


def test_one_that_is_ten_percent_better_is_found():
    """Errors of equal recordings go together: spread 0.3 in common and 0.15 apart, better in 69 of 100 trials."""
    found = 0
    for _ in range(100):
        common, own = RNG.normal(0.0, 0.3, 200), RNG.normal(0.0, 0.15, (2, 200))
        (pair,) = differences({"better": 0.9 * np.exp(common + own[0]), "other": np.exp(common + own[1])})
        found += pair.clear and pair.better > pair.worse
    assert found > 90


def test_the_evidence_of_equal_chances_is_the_integral_of_the_likelihood_ratio():
    p = (np.arange(20_000) + 0.5) / 20_000
    ratio = (p / 0.5) ** 14 * ((1 - p) / 0.5) ** 6
    assert log_evidence_of_bias(14, 20) == pytest.approx(np.log(ratio.mean()), abs=1e-6)
    assert log_evidence_of_bias(6, 20) == pytest.approx(log_evidence_of_bias(14, 20))
    sides = log_evidence([14, 6], [20, 20], 0.5)
    assert log_evidence_of_bias(14, 20) == pytest.approx(np.log(np.exp(sides).mean()))


def test_a_difference_once_clear_stays_so():
    signs = np.r_[np.ones(30), -np.ones(30)]
    found = [sequential_p(signs[:n]) for n in range(61)]
    assert found[0] == 1.0
    assert all(later <= sooner for sooner, later in itertools.pairwise(found))


@pytest.mark.parametrize("n", range(1, 6))
def test_few_values_have_least_and_greatest_as_ends(n):
    values = RNG.normal(size=n)
    found = median(values)
    assert (found.low, found.high) == (values.min(), values.max())
    assert found.value == pytest.approx(np.median(values))


def test_trials_without_estimate_count_as_infinitely_bad():
    values = np.r_[np.arange(1.0, 52.0), np.full(49, np.inf)]
    found = median(values)
    assert found.value == 50.5
    assert np.isfinite(found.low)
    assert found.high == np.inf
    assert median(np.full(7, np.inf)).low == np.inf
    assert not np.isnan(median(np.r_[1.0, np.inf]).value)


@pytest.mark.parametrize(("p", "n"), [(0.3, 100), (0.5, 60), (0.1, 200)])
def test_the_interval_of_a_rate_holds_it(p, n):
    """Summed over all outcomes instead of drawn; counts are whole, so an interval that never holds less holds more."""
    held = [rate(k, n).low <= p <= rate(k, n).high for k in range(n + 1)]
    assert 0.95 <= float(np.sum(binom.pmf(np.arange(n + 1), n, p) * held)) < 0.98


def test_no_failure_in_a_hundred_is_no_proof_of_none():
    assert rate(0, 100).high == pytest.approx(1 - 0.025 ** (1 / 100))


def test_claims_of_the_right_size_hold_three_and_too_small_ones_do_not():
    squares = chi2.rvs(3, size=(1000, 30), random_state=1)
    assert coverage([mean_square(row, 3) for row in squares], 3.0) == pytest.approx(0.95, abs=0.026)
    assert mean_square(4 * squares[0], 3).low > 3.0


def test_holm_as_in_his_paper():
    """His step-down: 0.01 x 4, then 0.02 x 3 = 0.06, then max(0.06, 0.022 x 2), then 0.5."""
    assert holm_corrected([0.5, 0.022, 0.01, 0.02]) == pytest.approx([0.5, 0.06, 0.04, 0.06])
    assert holm_corrected([]) == []


def test_differences_of_equals_are_found_in_five_of_a_hundred_comparisons_at_most():
    wrong = 0
    for _ in range(400):
        scores = {name: RNG.normal(size=30) for name in "abcd"}
        wrong += any(found.clear for found in differences(scores))
    assert wrong / 400 < 0.05 + 3 * np.sqrt(0.05 * 0.95 / 400)


def test_a_pair_is_counted_trial_by_trial():
    one, other = np.array([1.0, 2.0, np.inf, 4.0]), np.array([2.0, 1.0, np.inf, np.inf])
    (found,) = differences({"one": one, "other": other})
    assert (found.better, found.worse, found.equal, found.p) == (2, 1, 1, 1.0)
    (clear,) = differences({"one": np.zeros(20), "other": np.ones(20)})
    assert clear.clear
    assert clear.p == pytest.approx(21 * 0.5**20)  # 1 / E = (n + 1) / 2^n


def test_critical_difference_as_demsar_says():
    """Four classifiers on 14 data sets: q = 2.569, CD = 1.25 [Demsar2006, section 3.2.2]."""
    found = mean_ranks({name: RNG.normal(size=14) for name in "abcd"})
    assert found.critical == pytest.approx(2.569 * np.sqrt(4 * 5 / (6 * 14)), abs=2e-3)


def test_ranks_are_those_of_sorting():
    scores = {"a": np.array([1.0, 3.0, 2.0]), "b": np.array([2.0, 1.0, 2.0]), "c": np.array([3.0, 2.0, np.inf])}
    assert mean_ranks(scores).mean == pytest.approx(
        {"a": (1 + 3 + 1.5) / 3, "b": (2 + 1 + 1.5) / 3, "c": (3 + 2 + 3) / 3}
    )
    assert sum(mean_ranks(scores).mean.values()) == pytest.approx(6.0)
    assert list(itertools.islice(mean_ranks(scores).mean, 3)) == ["a", "b", "c"]


def test_a_difference_turned_round_is_the_other_s() -> None:
    (found,) = differences({"one": np.array([1.0, 2.0, 3.0, 4.0]), "other": np.array([2.0, 3.0, 2.0, 4.0])})
    turned = found.turned()
    assert (turned.one, turned.other) == ("other", "one")
    assert (turned.better, turned.worse, turned.equal, turned.p) == (1, 2, 1, found.p)
    assert found.turned().turned() == found


def test_equal_trials_say_nothing() -> None:
    signs = np.r_[np.ones(9), np.zeros(50), np.ones(3)]
    assert sequential_p(signs) == pytest.approx(13 / 2**12)
    assert sequential_p(np.zeros(9)) == 1.0


def test_the_ends_of_a_median_exclude_ranks_by_the_evidence() -> None:
    """2^n B(k + 1, n - k + 1) of twenty or more, the largest such k."""
    for n in (7, 8, 30, 101):
        k = excluded_ranks(n, 0.95)
        evidence = [2.0**n * beta(j + 1, n - j + 1) for j in range((n + 1) // 2)]
        assert k == max((j for j, found in enumerate(evidence) if found >= 20.0), default=0)
        found = median(np.arange(n, dtype=float))
        assert (found.low, found.high) == (k, n - 1 - k)

"""Probabilities of verdicts against every possible sequence and against simulation; defects in the score's space."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from scipy.special import ndtr

from validation.gates.power import (
    MOST_TRIALS,
    exceedance_of,
    factor_seen,
    fewest_trials,
    more_trials,
    smallest_exceedance,
    trials_to_fail,
    trials_to_pass,
    verdict_probabilities,
)
from validation.gates.sequential import SequentialTest, decide

USUAL = SequentialTest(0.5, 1e-5, 0.01)


@pytest.mark.parametrize("exceedance", [0.5, 0.8, 0.1])
def test_probabilities_are_the_sum_over_every_sequence(exceedance: float) -> None:
    test, most = SequentialTest(0.5, 0.05, 0.1), 12
    verdicts = {"pass": 0.0, "fail": 0.0, "inconclusive": 0.0}
    for sequence in itertools.product((0, 1), repeat=most):
        k = sum(sequence)
        verdicts[decide(test, sequence).verdict] += exceedance**k * (1 - exceedance) ** (most - k)
    failed, passed = verdict_probabilities(test, exceedance, most)
    assert failed[-1] == pytest.approx(verdicts["fail"], abs=1e-12)
    assert passed[-1] == pytest.approx(verdicts["pass"], abs=1e-12)


@pytest.mark.parametrize("allowed", [0.5, 0.1])
def test_at_the_limit_the_stated_rates_hold_after_every_look_of_thousands(allowed: float) -> None:
    """Exact, where a simulation of events of one in 100,000 could show nothing."""
    failed, passed = verdict_probabilities(SequentialTest(allowed, 1e-5, 0.01), allowed, 3000)
    assert 1e-6 < failed[-1] <= 1e-5
    assert 1e-3 < passed[-1] <= 0.01


def test_the_trials_that_a_defect_takes_are_those_that_a_simulation_takes() -> None:
    trials = trials_to_fail(USUAL, 0.85, 0.9)
    assert trials is not None
    rng = np.random.default_rng(3)
    failed = sum(decide(USUAL, rng.random(trials) < 0.85).verdict == "fail" for _ in range(2000))
    assert failed / 2000 == pytest.approx(0.9, abs=0.03)


def test_the_smallest_exceedance_is_the_one_that_takes_all_trials() -> None:
    p = smallest_exceedance(USUAL, 150, 0.99)
    assert 0.7 < p < 0.8
    assert trials_to_fail(USUAL, p, 0.99) == 150
    assert trials_to_fail(USUAL, p - 0.02, 0.99) > 150  # type: ignore[operator]


def test_too_few_trials_see_nothing_and_too_small_a_defect_is_never_seen() -> None:
    fewest = fewest_trials(USUAL)
    assert decide(USUAL, np.ones(fewest)).verdict == "fail"
    assert decide(USUAL, np.ones(fewest - 1)).verdict == "inconclusive"
    assert smallest_exceedance(USUAL, fewest - 1, 0.99) == math.inf
    assert smallest_exceedance(USUAL, fewest, 0.99) > 0.99
    assert trials_to_fail(USUAL, 0.51, 0.99) is None


@pytest.mark.parametrize(("exceeded", "trials"), [(50, 120), (80, 120), (0, 3)])
def test_more_trials_decide_when_they_go_on_alike(exceeded: int, trials: int) -> None:
    more = more_trials(USUAL, exceeded, trials)
    assert more is not None
    n = trials + more
    k = n * exceeded / trials
    assert USUAL.over(k, n) >= USUAL.failing or USUAL.within(k, n) >= USUAL.passing


def test_at_the_limit_itself_no_number_of_trials_decides() -> None:
    assert more_trials(USUAL, 60, 120) is None
    assert more_trials(USUAL, 0, 4990) is not None
    assert more_trials(USUAL, 2540, 4990) is None  # would decide beyond the most
    assert MOST_TRIALS == 5000  # as the pages say


@pytest.mark.parametrize("quantile", [0.5, 0.9])
@pytest.mark.parametrize("factor", [1.0, 1.5, 3.0])
def test_a_factor_on_a_log_normal_score_is_an_exceedance(factor: float, quantile: float) -> None:
    rng = np.random.default_rng(5)
    scores = np.exp(0.4 * rng.standard_normal(400_000))
    scores *= factor * 2.0 / np.quantile(scores, quantile)
    assert exceedance_of(factor, quantile, 0.4) == pytest.approx(np.mean(scores > 2.0), abs=3e-3)


def test_the_usual_spread_is_that_of_a_vector_of_normal_errors() -> None:
    lengths = np.linalg.norm(np.random.default_rng(6).standard_normal((200_000, 3)), axis=1)
    assert np.log(lengths).std() == pytest.approx(0.483, abs=0.005)  # sqrt(trigamma(3/2)) / 2


def test_the_factor_seen_brings_that_part_of_the_scores_over_the_limit() -> None:
    ratios = np.exp(0.5 * np.random.default_rng(7).standard_normal(201)) * 0.6
    factor = factor_seen(ratios, 0.8)
    assert np.mean(ratios * factor * (1 + 1e-9) > 1.0) >= 0.8
    assert np.mean(ratios * factor * (1 - 1e-9) > 1.0) < 0.8
    expected = math.exp(0.5 * 0.8416) / 0.6  # the 20 % quantile of the log-normal
    assert ndtr(-0.8416) == pytest.approx(0.2, abs=1e-4)
    assert factor == pytest.approx(expected, rel=0.1)


def test_estimates_that_failed_are_over_any_limit() -> None:
    assert factor_seen(np.array([np.inf, np.inf, 0.5]), 0.6) == 0.0
    assert factor_seen(np.array([0.5, 0.5]), math.inf) == math.inf


def test_the_factor_seen_is_of_the_least_number_of_trials_that_is_such_a_share() -> None:
    """Of four ratios a quarter is the largest, a little more the two largest; all of them, the least."""
    ratios = np.array([0.5, 0.25, 0.2, 0.8])
    assert factor_seen(ratios, 0.25) == pytest.approx(1 / 0.8)
    assert factor_seen(ratios, 0.26) == pytest.approx(1 / 0.5)
    assert factor_seen(ratios, 1.0) == pytest.approx(1 / 0.2)
    assert factor_seen(ratios, 0.0) == pytest.approx(1 / 0.8)  # one at least
    assert factor_seen(np.zeros(3), 0.5) == math.inf
    assert factor_seen(np.zeros(0), 0.5) == math.inf


def test_trials_to_pass_and_to_fail_are_the_first_with_that_probability() -> None:
    for count, exceedance, k in ((trials_to_pass, 0.2, 1), (trials_to_fail, 0.9, 0)):
        n = count(USUAL, exceedance, 0.9)
        assert n is not None
        reached = verdict_probabilities(USUAL, exceedance, n)[k]
        assert reached[-1] >= 0.9 > reached[-2]

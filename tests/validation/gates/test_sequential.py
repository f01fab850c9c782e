"""The evidence against numerical integration, and the rate of false verdicts against every possible sequence."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from scipy.integrate import quad

from validation.comparison.sequential_evidence import log_evidence
from validation.gates.sequential import SequentialTest, decide


@pytest.mark.parametrize("allowed", [0.5, 0.05, 0.8])
@pytest.mark.parametrize(("exceeded", "trials"), [(0, 1), (1, 1), (3, 7), (20, 20), (0, 40), (27, 60)])
def test_the_evidence_is_the_integral_of_the_likelihood_ratio(exceeded: int, trials: int, allowed: float) -> None:
    def ratio(p: float) -> float:
        return float((p / allowed) ** exceeded * ((1 - p) / (1 - allowed)) ** (trials - exceeded) / (1 - allowed))

    integral, _ = quad(ratio, allowed, 1.0, epsabs=0.0, epsrel=1e-12)
    assert log_evidence(exceeded, trials, allowed) == pytest.approx(math.log(integral), abs=1e-9)


@pytest.mark.parametrize("allowed", [0.5, 0.1])
@pytest.mark.parametrize("chance", [1.0, 0.6, 0.0])
def test_the_evidence_does_not_grow_on_average_where_the_limit_is_kept(allowed: float, chance: float) -> None:
    """The supermartingale property itself, after each possible history; equality at the boundary of the hypothesis."""
    p = allowed * chance
    for trials in range(40):
        k = np.arange(trials + 1)
        after = (1 - p) * np.exp(log_evidence(k, trials + 1, allowed)) + p * np.exp(
            log_evidence(k + 1, trials + 1, allowed)
        )
        before = np.exp(log_evidence(k, trials, allowed))
        assert np.all(after <= before * (1 + 1e-9))
        if chance == 1.0:
            np.testing.assert_allclose(after, before, rtol=1e-9)


def test_no_more_sequences_fail_than_stated() -> None:
    """All 2^11 sequences at P(exceed) = p0, looked at after every trial."""
    test = SequentialTest(0.5, false_fail_rate=0.05, false_pass_rate=0.1)
    verdicts = [decide(test, sequence).verdict for sequence in itertools.product((0, 1), repeat=11)]
    assert 0.01 < verdicts.count("fail") / len(verdicts) <= 0.05
    assert 0.02 < verdicts.count("pass") / len(verdicts) <= 0.1


def test_what_is_over_the_limit_every_time_fails_and_what_never_is_passes() -> None:
    test = SequentialTest(0.5, 1e-5, 0.01)
    always, never = decide(test, np.ones(100)), decide(test, np.zeros(100))
    assert (always.verdict, never.verdict) == ("fail", "pass")
    # all n exceed: E = 2 (2^(n + 1) - 1) / (2 (n + 1)), the integral done by hand
    by_hand = [math.log((2 ** (n + 1) - 1) / (n + 1)) for n in range(1, 100)]
    assert always.trials == 1 + int(np.argmax(np.array(by_hand) >= math.log(1e5)))
    assert never.trials == 1 + int(np.argmax(np.array(by_hand) >= math.log(1e2)))
    np.testing.assert_allclose(always.over, by_hand[: always.trials], rtol=1e-9)


def test_trials_after_the_decision_change_nothing() -> None:
    test = SequentialTest(0.5, 1e-3, 0.01)
    rng = np.random.default_rng(1)
    trials = rng.random(300) < 0.8
    first = decide(test, trials)
    assert first.verdict == "fail"
    assert first.trials < 200
    second = decide(test, np.concatenate((trials[: first.trials], np.zeros(300))))
    assert second.verdict == first.verdict
    np.testing.assert_array_equal(second.over, first.over)
    assert decide(test, trials[: first.trials - 1]).verdict == "inconclusive"


@pytest.mark.parametrize("test", [SequentialTest(0.5, 1e-4, 0.01), SequentialTest(0.05, 1e-3, 0.05)])
def test_the_bounds_are_where_the_evidence_is_enough(test: SequentialTest) -> None:
    fails, passes = test.fails_from(90), test.passes_to(90)
    for n in range(91):
        k = np.arange(n + 1)
        over, within = test.over(k, n) >= test.failing, test.within(k, n) >= test.passing
        assert fails[n] == (k[over].min() if over.any() else n + 1)
        assert passes[n] == (k[within].max() if within.any() else -1)


def test_evidence_too_small_for_a_double_counts_for_nothing() -> None:
    assert log_evidence(0, 5000, 0.5) == -math.inf
    assert decide(SequentialTest(0.5, 1e-5, 0.01), np.zeros(0)).verdict == "inconclusive"

"""Power of a sequential test: verdict probabilities, trials needed for a defect, smallest detectable defect."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache

import numpy as np
from scipy.special import ndtr, ndtri

from scenarios.arrays import Array
from validation.gates.sequential import Counts, SequentialTest

MOST_TRIALS = 5_000
"""Largest number of trials of a gate; a gate that needs more has a limit too close to the measured value."""
USUAL_SPREAD = 0.5
"""Standard deviation of ln(score) from trial to trial; 0.48 for the length of three equal, normal errors."""
BISECTIONS = 16


def verdict_probabilities(test: SequentialTest, exceedance: float, most: int) -> tuple[Array, Array]:
    """Return P(failed by trial n) and P(passed by trial n), n = 0 ... most, for P(exceed) = exceedance in each trial.

    Exact: the distribution of the number of exceedances over undecided sequences, propagated trial by trial.
    """
    failing, passing = _bounds(test, most)
    failed, passed = np.zeros(most + 1), np.zeros(most + 1)
    undecided = np.zeros(most + 2)
    undecided[0] = 1.0
    for n in range(1, most + 1):
        low, high = max(int(passing[n - 1]), 0), int(failing[n - 1]) + 1  # of n - 1 trials: at most n, which is none
        stay = undecided[low:high] * (1.0 - exceedance)
        stay[1:] += undecided[low : high - 1] * exceedance
        undecided[low:high] = stay
        failed[n] = undecided[failing[n] : high].sum()
        passed[n] = undecided[low : passing[n] + 1].sum()
        undecided[failing[n] : high] = 0.0
        undecided[low : passing[n] + 1] = 0.0
    return np.cumsum(failed), np.cumsum(passed)


@lru_cache(maxsize=64)
def _bounds(test: SequentialTest, most: int) -> tuple[Counts, Counts]:
    return test.fails_from(most), test.passes_to(most)


def trials_to_fail(test: SequentialTest, exceedance: float, power: float) -> int | None:
    """Return the trials within which an exceedance fails with probability `power`; None above MOST_TRIALS."""
    return _first(lambda most: verdict_probabilities(test, exceedance, most)[0], power)


def trials_to_pass(test: SequentialTest, exceedance: float, power: float) -> int | None:
    """Return the trials within which an exceedance passes with probability `power`; None above MOST_TRIALS."""
    return _first(lambda most: verdict_probabilities(test, exceedance, most)[1], power)


def _first(probabilities: Callable[[int], Array], power: float) -> int | None:
    """Return the first trial by which a cumulative probability reaches the power, by doubling the length."""
    most = 64
    while most < 2 * MOST_TRIALS:
        enough = np.flatnonzero(probabilities(min(most, MOST_TRIALS)) >= power)
        if len(enough):
            return int(enough[0])
        most *= 2
    return None


def fewest_trials(test: SequentialTest) -> int:
    """Return the trials needed to fail a calibrator that exceeds the limit in every trial."""
    n = np.arange(MOST_TRIALS + 1)
    return int(np.flatnonzero(test.over(n, n) >= test.failing)[0])


@lru_cache(maxsize=256)
def smallest_exceedance(test: SequentialTest, most: int, power: float) -> float:
    """Return the smallest exceedance that fails within `most` trials with probability `power`; infinite for none."""
    if most < fewest_trials(test):
        return math.inf
    low, high = test.allowed, 1.0
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        seen = verdict_probabilities(test, middle, most)[0][-1] >= power
        low, high = (low, middle) if seen else (middle, high)
    return high


def more_trials(test: SequentialTest, exceeded: int, trials: int) -> int | None:
    """Return the further trials that decide if exceedances continue at the present rate; None above MOST_TRIALS."""
    n = np.arange(trials, MOST_TRIALS + 1)
    k = n * (exceeded / trials)
    decided = (test.over(k, n) >= test.failing) | (test.within(k, n) >= test.passing)
    return int(np.argmax(decided)) if decided.any() else None


def exceedance_of(factor: float, quantile: float, spread: float) -> float:
    """Return P(score > limit) of a calibrator whose quantile of the score is `factor` times the limit.

    Phi(ln(factor) / spread - Phi^-1(quantile)), for a log-normal score; spread : standard deviation of ln(score).
    """
    return float(ndtr(math.log(factor) / spread - ndtri(quantile)))


def factor_seen(ratios: Array, exceedance: float) -> float:
    """Return the factor on scores that lifts a share `exceedance` over the limit, from ratios score / limit (n,).

    1 / r, with r the largest ratio reached by the share; 0 where r belongs to a failed estimate, infinite where no
    exceedance is detectable.
    """
    if not math.isfinite(exceedance) or not len(ratios):
        return math.inf
    reaching = max(1, math.ceil(exceedance * len(ratios)))
    ratio = float(np.sort(ratios)[-reaching])
    return 1.0 / ratio if ratio > 0.0 else math.inf

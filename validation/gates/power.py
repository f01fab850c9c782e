"""What a sequential test can see: probabilities of its verdicts, trials that a defect takes, the smallest defect."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache

import numpy as np
from scipy.special import ndtr, ndtri

from scenarios.arrays import Array
from validation.gates.sequential import Counts, SequentialTest

MOST_TRIALS = 5_000
"""A gate that takes more trials than this has a limit too near to what it measures."""
USUAL_SPREAD = 0.5
"""Standard deviation of ln(score) from trial to trial; 0.48 for the length of three equal, normal errors."""
BISECTIONS = 16


def verdict_probabilities(test: SequentialTest, exceedance: float, most: int) -> tuple[Array, Array]:
    """P(failed by trial n) and P(passed by trial n), n = 0 ... most, where each trial exceeds with that probability.

    Exact: the distribution of the number of exceedances among the sequences that are not decided yet, trial by trial.
    """
    failing, passing = _bounds(test, most)
    failed, passed = np.zeros(most + 1), np.zeros(most + 1)
    undecided = np.zeros(most + 2)
    undecided[0] = 1.0
    for n in range(1, most + 1):
        low, high = max(int(passing[n - 1]), 0), min(int(failing[n - 1]) + 1, n + 1)
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
    """Trials within which this exceedance fails with that probability; None for more than MOST_TRIALS."""
    return _first(lambda most: verdict_probabilities(test, exceedance, most)[0], power)


def trials_to_pass(test: SequentialTest, exceedance: float, power: float) -> int | None:
    """Trials within which this exceedance passes with that probability; None for more than MOST_TRIALS."""
    return _first(lambda most: verdict_probabilities(test, exceedance, most)[1], power)


def _first(probabilities: Callable[[int], Array], power: float) -> int | None:
    """The first trial by which a probability reaches the power; looked for in ever longer runs."""
    most = 64
    while most < 2 * MOST_TRIALS:
        enough = np.flatnonzero(probabilities(min(most, MOST_TRIALS)) >= power)
        if len(enough):
            return int(enough[0])
        most *= 2
    return None


def fewest_trials(test: SequentialTest) -> int:
    """Trials that a calibrator takes to fail which exceeds its limit every time."""
    n = np.arange(MOST_TRIALS + 1)
    return int(np.flatnonzero(test.over(n, n) >= test.failing)[0])


@lru_cache(maxsize=256)
def smallest_exceedance(test: SequentialTest, most: int, power: float) -> float:
    """Smallest exceedance that fails within so many trials with that probability; infinity where none does."""
    if most < fewest_trials(test):
        return math.inf
    low, high = test.allowed, 1.0
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        seen = verdict_probabilities(test, middle, most)[0][-1] >= power
        low, high = (low, middle) if seen else (middle, high)
    return high


def more_trials(test: SequentialTest, exceeded: int, trials: int) -> int | None:
    """Trials beyond these that decide, if exceedances go on at the rate so far; None for more than MOST_TRIALS."""
    n = np.arange(trials, MOST_TRIALS + 1)
    k = n * (exceeded / trials)
    decided = (test.over(k, n) >= test.failing) | (test.within(k, n) >= test.passing)
    return int(np.argmax(decided)) if decided.any() else None


def exceedance_of(factor: float, quantile: float, spread: float) -> float:
    """P(score > limit) of a calibrator whose quantile of the score is that factor times the limit.

    Phi(ln(factor) / spread - Phi^-1(quantile)), for a log-normal score of that spread: standard deviation of ln(score).
    """
    return float(ndtr(math.log(factor) / spread - ndtri(quantile)))


def factor_seen(ratios: Array, exceedance: float) -> float:
    """The factor on scores at which that part of them, or more, is over the limit: from ratios score / limit (n,).

    1 / r, r the largest ratio that so many reach; 0 where that is an estimate that failed, and infinity where no
    exceedance is seen.
    """
    if not math.isfinite(exceedance) or not len(ratios):
        return math.inf
    reaching = max(1, math.ceil(exceedance * len(ratios)))
    ratio = float(np.sort(ratios)[-reaching])
    return 1.0 / ratio if ratio > 0.0 else math.inf

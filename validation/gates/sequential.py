"""A sequential test of how often a score is over its limit; it may be looked at after every trial."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import betaincc, betaln

from scenarios.arrays import Array

Verdict = Literal["pass", "fail", "inconclusive"]
Counts = NDArray[np.int64]


def log_evidence(exceeded: ArrayLike, trials: ArrayLike, allowed: float) -> Array:
    """ln E, E the evidence of k exceedances in n trials against P(exceed) <= p0.

    E_n = integral over p in [p0, 1] of (p / p0)^k ((1 - p) / (1 - p0))^(n - k) dp / (1 - p0)
        = B(k + 1, n - k + 1) (1 - I_p0(k + 1, n - k + 1)) / (p0^k (1 - p0)^(n - k + 1)),

    the likelihood ratio averaged over every p above p0 alike: a beta-binomial mixture, truncated to the alternative.
    For each p > p0 the ratio of one more trial has expectation at most 1 whatever P(exceed) <= p0 is, so E is a
    supermartingale that begins at 1, and P(E_n >= 1 / a for any n) <= a: Ville's inequality [Ville1939]; on tests of
    this kind [Howard2021], [WaudbySmith2024]. It holds wherever one stops, and however often one looked before.

    exceeded, trials : k and n, of one shape; allowed : p0, between 0 and 1. Where the integral is too small for a
    double the answer is -inf: less evidence than there is, which keeps the inequality.
    """
    k, n = np.asarray(exceeded, dtype=float), np.asarray(trials, dtype=float)
    misses = n - k
    with np.errstate(divide="ignore"):
        tail = np.log(betaincc(k + 1.0, misses + 1.0, allowed))
    null = k * math.log(allowed) + (misses + 1.0) * math.log1p(-allowed)
    return np.asarray(betaln(k + 1.0, misses + 1.0) + tail - null)


@dataclass(frozen=True)
class SequentialTest:
    """Whether a score is over its limit in more than the allowed part of the trials.

    allowed : p0, one less the quantile that the gate is about; 0.5 for the median.
    false_fail_rate : greatest probability that a calibrator with P(exceed) <= p0 ever fails.
    false_pass_rate : greatest probability that a calibrator with P(exceed) >= p0 ever passes.
    """

    allowed: float
    false_fail_rate: float
    false_pass_rate: float

    @property
    def failing(self) -> float:
        """ln of the evidence that fails."""
        return -math.log(self.false_fail_rate)

    @property
    def passing(self) -> float:
        """ln of the evidence that passes."""
        return -math.log(self.false_pass_rate)

    def over(self, exceeded: ArrayLike, trials: ArrayLike) -> Array:
        """ln of the evidence that the limit is exceeded too often."""
        return log_evidence(exceeded, trials, self.allowed)

    def within(self, exceeded: ArrayLike, trials: ArrayLike) -> Array:
        """ln of the evidence that the limit is kept."""
        return log_evidence(np.subtract(trials, exceeded), trials, 1.0 - self.allowed)

    def fails_from(self, most: int) -> Counts:
        """Least number of exceedances that fails after n = 0 ... most trials; n + 1 where none does."""
        return _least_count(lambda k, n: self.over(k, n) >= self.failing, most)

    def passes_to(self, most: int) -> Counts:
        """Greatest number of exceedances that passes after n = 0 ... most trials; -1 where none does."""
        kept = _least_count(lambda kept, n: self.within(n - kept, n) >= self.passing, most)
        return np.arange(most + 1) - kept


@dataclass(frozen=True)
class Decision:
    """What a sequence of trials decided, and the way there.

    exceeded (n,) : whether each trial that was looked at was over the limit. over, within (n,) : ln of the evidence
    for either side after it. The verdict is `inconclusive` where neither is enough.
    """

    verdict: Verdict
    exceeded: NDArray[np.bool_]
    over: Array
    within: Array

    @property
    def trials(self) -> int:
        """Trials that were looked at, none after the one that decided."""
        return len(self.exceeded)


def decide(test: SequentialTest, exceeded: ArrayLike) -> Decision:
    """Look at the trials in their order, after each of them, and stop at the first that decides."""
    seen = np.asarray(exceeded, dtype=bool)
    n, k = np.arange(1, len(seen) + 1), np.cumsum(seen)
    over, within = test.over(k, n), test.within(k, n)
    failed, passed = over >= test.failing, within >= test.passing
    decided = np.flatnonzero(failed | passed)
    looked = int(decided[0]) + 1 if len(decided) else len(seen)
    verdict: Verdict = "inconclusive"
    if len(decided):
        verdict = "fail" if failed[looked - 1] else "pass"
    return Decision(verdict, seen[:looked], over[:looked], within[:looked])


def _least_count(enough: Callable[[Counts, Counts], NDArray[np.bool_]], most: int) -> Counts:
    """Least k in 0 ... n that is enough, n + 1 where none is, for n = 0 ... most: bisection, for all n at once.

    What is enough stays so as k grows, since every likelihood ratio in the mixture grows with k.
    """
    n = np.arange(most + 1)
    low, high = np.zeros_like(n), n + 1
    while np.any(low < high):
        middle = (low + high) // 2
        found = enough(np.minimum(middle, n), n) | (middle > n)
        low, high = np.where(found, low, middle + 1), np.where(found, middle, high)
    return low

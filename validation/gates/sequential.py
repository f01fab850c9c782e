"""Sequential test of how often a score exceeds a limit, valid after every trial."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from scenarios.arrays import Array
from validation.comparison.sequential_evidence import log_evidence

Verdict = Literal["pass", "fail", "inconclusive"]
Counts = NDArray[np.int64]


@dataclass(frozen=True)
class SequentialTest:
    """Test whether a score exceeds the limit in more than the allowed share of trials.

    allowed : p0 = 1 - quantile of the gate; 0.5 for the median.
    false_fail_rate : largest probability that a calibrator with P(exceed) <= p0 ever fails.
    false_pass_rate : largest probability that a calibrator with P(exceed) >= p0 ever passes.
    """

    allowed: float
    false_fail_rate: float
    false_pass_rate: float

    @property
    def failing(self) -> float:
        """ln of the evidence needed to fail."""
        return -math.log(self.false_fail_rate)

    @property
    def passing(self) -> float:
        """ln of the evidence needed to pass."""
        return -math.log(self.false_pass_rate)

    def over(self, exceeded: ArrayLike, trials: ArrayLike) -> Array:
        """Return ln of the evidence that the limit is exceeded too often."""
        return log_evidence(exceeded, trials, self.allowed)

    def within(self, exceeded: ArrayLike, trials: ArrayLike) -> Array:
        """Return ln of the evidence that the limit is kept."""
        return log_evidence(np.subtract(trials, exceeded), trials, 1.0 - self.allowed)

    def fails_from(self, most: int) -> Counts:
        """Return the smallest number of exceedances that fails after n = 0 ... most trials; n + 1 for none."""
        return _least_count(lambda k, n: self.over(k, n) >= self.failing, most)

    def passes_to(self, most: int) -> Counts:
        """Return the largest number of exceedances that passes after n = 0 ... most trials; -1 for none."""
        kept = _least_count(lambda kept, n: self.within(n - kept, n) >= self.passing, most)
        return np.arange(most + 1) - kept


@dataclass(frozen=True)
class Decision:
    """Verdict of a sequence of trials with the trajectory of the evidence.

    exceeded (n,) : whether each trial exceeded the limit. over, within (n,) : ln of the evidence for exceeding and for
    keeping the limit after each trial. The verdict is `inconclusive` where neither suffices.
    """

    verdict: Verdict
    exceeded: NDArray[np.bool_]
    over: Array
    within: Array

    @property
    def trials(self) -> int:
        """Number of trials up to the deciding trial."""
        return len(self.exceeded)


def decide(test: SequentialTest, exceeded: ArrayLike) -> Decision:
    """Test trials in order and stop at the first decision."""
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
    """Return the smallest sufficient k in 0 ... n, n + 1 for none, for n = 0 ... most; bisection over all n at once.

    Sufficiency is monotonic in k, since every likelihood ratio in the mixture grows with k.
    """
    n = np.arange(most + 1)
    low, high = np.zeros_like(n), n + 1
    while np.any(low < high):
        middle = (low + high) // 2
        found = enough(np.minimum(middle, n), n) | (middle > n)
        low, high = np.where(found, low, middle + 1), np.where(found, middle, high)
    return low

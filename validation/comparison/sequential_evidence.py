"""Evidence of counts that is valid after every trial: for the gates' limits, paired differences and medians."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import betaincc, betaln

from scenarios.arrays import Array

ROUNDING = 1e-12
"""ln of the evidence that is none but rounding."""


def log_evidence(exceeded: ArrayLike, trials: ArrayLike, allowed: float) -> Array:
    """Return ln E, the evidence of k exceedances in n trials against P(exceed) <= p0.

    E_n = integral over p in [p0, 1] of (p / p0)^k ((1 - p) / (1 - p0))^(n - k) dp / (1 - p0)
        = B(k + 1, n - k + 1) (1 - I_p0(k + 1, n - k + 1)) / (p0^k (1 - p0)^(n - k + 1)),

    the likelihood ratio averaged uniformly over p > p0: a beta-binomial mixture, truncated to the alternative.
    For each p > p0 the ratio of a further trial has expectation at most 1 for every P(exceed) <= p0, so E is a
    supermartingale that starts at 1, and P(E_n >= 1 / a for any n) <= a: Ville's inequality [Ville1939], for any
    stopping time and any number of looks [Howard2021], [WaudbySmith2024].

    exceeded, trials : k and n, of equal shape. allowed : p0, between 0 and 1. An integral below the range of a double
    gives -inf, an underestimate that keeps the inequality.
    """
    k, n = np.asarray(exceeded, dtype=float), np.asarray(trials, dtype=float)
    misses = n - k
    with np.errstate(divide="ignore"):
        tail = np.log(betaincc(k + 1.0, misses + 1.0, allowed))
    null = k * math.log(allowed) + (misses + 1.0) * math.log1p(-allowed)
    return np.asarray(betaln(k + 1.0, misses + 1.0) + tail - null)


def log_evidence_of_bias(counted: ArrayLike, trials: ArrayLike) -> Array:
    """Return ln E, the evidence of k of n against P = 1/2, to either side.

    E_n = 2^n B(k + 1, n - k + 1), the mean of `log_evidence` to both sides at p0 = 1/2: the likelihood ratio averaged
    uniformly over 0 < p < 1. The mean of two supermartingales that start at 1 is one too, so P(E_n >= 1 / a for any n)
    <= a for P = 1/2.

    counted, trials : k and n, of equal shape.
    """
    k, n = np.asarray(counted, dtype=float), np.asarray(trials, dtype=float)
    return np.asarray(betaln(k + 1.0, n - k + 1.0) + n * math.log(2.0))


def sequential_p(signs: ArrayLike) -> float:
    """Return the p value of paired trials that holds at every look: 1 / the largest evidence so far, at most 1.

    signs (n,) : negative, zero or positive of each trial in order; equal trials (zero) say nothing. The value never
    grows with more trials [Howard2021].
    """
    told = np.asarray(signs, dtype=float)
    told = told[told != 0]
    evidence = log_evidence_of_bias(np.cumsum(told > 0), np.arange(1, len(told) + 1))
    most = float(evidence.max(initial=0.0))
    return math.exp(-most) if most > ROUNDING else 1.0


@lru_cache(maxsize=4096)
def excluded_ranks(trials: int, level: float) -> int:
    """Return how many values at either end of n sorted ones the median exceeds, at confidence `level` at every look.

    The largest k < n / 2 whose evidence against P(below the median) = 1/2 reaches 1 / (1 - level); 0 for none.
    """
    k = np.arange((trials + 1) // 2)
    enough = np.flatnonzero(log_evidence_of_bias(k, np.full_like(k, trials)) >= -math.log1p(-level))
    return int(enough[-1]) if len(enough) else 0

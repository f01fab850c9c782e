"""Statistics over trials with intervals: medians, rates, paired differences, ranks.

A trial without estimate counts as inf. All intervals and tests are distribution-free, based on order and counts.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import binom, binomtest, chi2, rankdata, studentized_range

from scenarios.arrays import Array

LEVEL = 0.95
"""Confidence level of every interval; tests use significance 1 - LEVEL."""


@dataclass(frozen=True)
class Interval:
    """Estimate with a confidence interval of level LEVEL."""

    value: float
    low: float
    high: float


def median(values: Array) -> Interval:
    """Return the median of values (n,), n > 0, with an interval between interpolated order statistics.

    x_(k) and x_(n+1-k) hold the median with g_k = 1 - 2 P(Bin(n, 1/2) < k); the ends lie between those of k and k+1,
    g_k >= LEVEL > g_{k+1}, at lambda = (n - k) I / (k + (n - 2 k) I), I = (g_k - LEVEL) / (g_k - g_{k+1})
    [HettmanspergerSheather1986]. The percentile bootstrap of a median takes order statistics too, but holds 93.5 %
    instead of 95 at n = 50. Below six values the interval is the range, with level 1 - 2^(1-n).
    """
    x, n = np.sort(values), len(values)
    k = max(1, int(binom.ppf((1 - LEVEL) / 2, n, 0.5)))
    inner, outer = 1 - 2 * binom.cdf(k, n, 0.5), 1 - 2 * binom.cdf(k - 1, n, 0.5)
    share = (outer - LEVEL) / (outer - inner) if outer > LEVEL else 0.0
    step = (n - k) * share / (k + (n - 2 * k) * share)
    return Interval(
        _middle(x), _between(x[k - 1], x[min(k, n - 1)], step), _between(x[n - k], x[max(n - k - 1, 0)], step)
    )


def _middle(x: Array) -> float:
    """Return the median of sorted values; infinite where a middle value is infinite."""
    return _between(x[(len(x) - 1) // 2], x[len(x) // 2], 0.5)


def _between(one: float, other: float, share: float) -> float:
    """Interpolate between two values; infinite where a value with weight is infinite."""
    return float(one) if one == other or share == 0.0 else float((1 - share) * one + share * other)


def rate(events: int, n: int) -> Interval:
    """Return a rate of events with the exact Clopper-Pearson interval, of level LEVEL or more."""
    ends = binomtest(events, n).proportion_ci(LEVEL, method="exact")
    return Interval(events / n, float(ends.low), float(ends.high))


def mean_square(squares: Array, degrees: int) -> Interval:
    """Return the mean of n normalised squared errors e^T C^-1 e of `degrees` components; `degrees` for true claims.

    n mean follows a scaled chi-square distribution of n degrees degrees of freedom, which gives the interval.
    """
    total, freedom = float(squares.sum()), degrees * len(squares)
    ends = (degrees * total / chi2.isf(tail, freedom) for tail in ((1 - LEVEL) / 2, (1 + LEVEL) / 2))
    return Interval(total / len(squares), *ends)


@dataclass(frozen=True)
class Difference:
    """Paired comparison of two calibrators, `one` and `other`, over equal trials.

    better, worse, equal : numbers of trials. p : sign test, corrected for the number of pairs [Holm1979].
    """

    one: str
    other: str
    better: int
    worse: int
    equal: int
    p: float

    @property
    def clear(self) -> bool:
        """Whether the difference is significant."""
        return self.p < 1 - LEVEL

    def turned(self) -> Difference:
        """Return the difference with the calibrators exchanged."""
        return replace(self, one=self.other, other=self.one, better=self.worse, worse=self.better)


def differences(scores: Mapping[str, Array]) -> list[Difference]:
    """Compare every pair of calibrators; scores (n,) by name, lower is better."""
    pairs = list(itertools.combinations(scores, 2))
    counts = [_compared(scores[one], scores[other]) for one, other in pairs]
    raw = [binomtest(better, better + worse).pvalue if better + worse else 1.0 for better, worse, _ in counts]
    return [Difference(*pair, *count, p) for pair, count, p in zip(pairs, counts, holm_corrected(raw), strict=True)]


def _compared(one: Array, other: Array) -> tuple[int, int, int]:
    """Return the numbers of trials with `one` lower, higher, and equal."""
    better, worse = int(np.sum(one < other)), int(np.sum(one > other))
    return better, worse, len(one) - better - worse


def holm_corrected(p: Sequence[float]) -> list[float]:
    """Return Holm-corrected p values of m tests: running maximum of (m - rank) p, at most 1 [Holm1979]."""
    order = np.argsort(p, kind="stable")
    stepped = np.maximum.accumulate(np.asarray(p, dtype=float)[order] * np.arange(len(p), 0, -1)) if len(p) else order
    out = np.empty(len(p))
    out[order] = np.minimum(stepped, 1.0)
    return [float(value) for value in out]


@dataclass(frozen=True)
class Ranks:
    """Mean rank of each calibrator over the trials (1: best), and the critical difference of mean ranks."""

    mean: dict[str, float]
    critical: float


def mean_ranks(scores: Mapping[str, Array]) -> Ranks:
    """Return mean ranks of k >= 2 calibrators over n trials.

    Critical difference (Nemenyi): q sqrt(k (k + 1) / (6 n)) [Demsar2006].
    """
    table = np.array(list(scores.values()))
    k, n = table.shape
    q = float(studentized_range.isf(1 - LEVEL, k, np.inf)) / np.sqrt(2.0)
    means = rankdata(table, axis=0).mean(axis=1)
    return Ranks(dict(zip(scores, map(float, means), strict=True)), float(q * np.sqrt(k * (k + 1) / (6.0 * n))))

"""Statistics over trials with intervals: medians, rates, paired differences, ranks.

A trial without estimate counts as inf. All intervals and tests are distribution-free, based on order and counts.
Intervals of medians and differences hold at every look, since a comparison may be extended by more trials.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import binomtest, chi2, norm, rankdata, studentized_range

from scenarios.arrays import Array
from validation.comparison.sequential_evidence import excluded_ranks, sequential_p

LEVEL = 0.95
"""Confidence level of every interval; tests use significance 1 - LEVEL."""


@dataclass(frozen=True)
class Interval:
    """Estimate with a confidence interval of level LEVEL."""

    value: float
    low: float
    high: float


def median(values: Array) -> Interval:
    """Return the median of values (n,), n > 0, with a confidence sequence: the interval holds at every n together.

    The ends are x_(k + 1) and x_(n - k), k of `excluded_ranks`: the values m for which the evidence against
    P(x < m) = 1/2 stays below 1 / (1 - LEVEL) [Howard2021]. Below eight values the interval is the range.
    """
    x, n = np.sort(values), len(values)
    k = excluded_ranks(n, LEVEL)
    return Interval(_middle(x), float(x[k]), float(x[n - 1 - k]))


def width_ratio(n: int) -> float:
    """Return the width of a median's interval over that of n trials fixed in advance, counted in ranks: z sqrt(n)."""
    fixed = min(n, float(norm.ppf((1 + LEVEL) / 2)) * np.sqrt(n))
    return float((n - 2 * excluded_ranks(n, LEVEL)) / fixed)


def _middle(x: Array) -> float:
    """Return the median of sorted values; infinite where a middle value is infinite."""
    one, other = float(x[(len(x) - 1) // 2]), float(x[len(x) // 2])
    return (one + other) / 2


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

    better, worse, equal : numbers of trials. p : sequential sign test, the same at any number of looks, corrected for
    the number of pairs [Holm1979].
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
    """Compare every pair of calibrators; scores (n,) by name in the order of trials, lower is better."""
    pairs = list(itertools.combinations(scores, 2))
    counts = [_compared(scores[one], scores[other]) for one, other in pairs]
    raw = [sequential_p(_signs(scores[one], scores[other])) for one, other in pairs]
    return [Difference(*pair, *count, p) for pair, count, p in zip(pairs, counts, holm_corrected(raw), strict=True)]


def _compared(one: Array, other: Array) -> tuple[int, int, int]:
    """Return the numbers of trials with `one` lower, higher, and equal."""
    better, worse = int(np.sum(one < other)), int(np.sum(one > other))
    return better, worse, len(one) - better - worse


def _signs(one: Array, other: Array) -> Array:
    """Return +1 where `one` is lower, -1 where higher, 0 where equal or both infinite."""
    return (one < other).astype(float) - (one > other)


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

"""Mean of paired differences over neighbouring blocks of time, with a confidence interval."""

from __future__ import annotations

import numpy as np
from scipy.special import stdtrit

from scenarios.arrays import Array

SURE = 0.95
"""Probability of the interval."""


def counted(*series: Array) -> float:
    """Effective number of n blocks, ``n (1 - r) / (1 + r)``, r >= 0 the correlation of neighbours in series (n, k)."""
    count = len(series[0])
    worst = max(neighbours(values) for values in series) - 1.0 / np.sqrt(count)
    return float(count * (1.0 - max(0.0, worst)) / (1.0 + max(0.0, worst)))


def mean_interval(differences: Array, effective: float) -> tuple[float, float]:
    """Student's 95 % interval of the mean of differences (n,) that count for `effective` independent ones."""
    if effective < 2.0:
        return -np.inf, np.inf
    mean, std = float(differences.mean()), float(differences.std(ddof=1)) / np.sqrt(effective)
    reach = float(stdtrit(effective - 1.0, 0.5 + SURE / 2.0)) * std
    return mean - reach, mean + reach


def neighbours(values: Array) -> float:
    """Correlation of neighbours in values (n, k)."""
    off = values - values.mean(axis=0)
    total = float(np.sum(off**2))
    return float(np.sum(off[1:] * off[:-1])) / total if total > 0 else 0.0

"""Residual structure too fast for the tested means: a spectrum that rises with frequency, unlike any sensor noise."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import isotonic_regression
from scipy.stats import chi2, median_abs_deviation

from diagnosis.evidence.along_field import within_stated_errors
from diagnosis.evidence.residual_tests import bridge_unused, mean_lengths_s
from diagnosis.policy import Policy
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from validation.signals.bands import Bands
from validation.text import figure


@dataclass(frozen=True)
class RisingSpectrum:
    """Frequency range of a rising spectrum; hides: the names act there and explain almost nothing of the rise."""

    low_hz: float
    high_hz: float
    hides: bool

    @classmethod
    def of(cls, problem: LinearProblem, before: Array, after: Array) -> RisingSpectrum | None:
        """The rise in the spectrum of a residual (n, q) after the named effects; None for a falling spectrum.

        Targets tones of a wheel or propeller with varying speed, neither a spectral line nor visible in means over a
        second. Attitude errors are as fast as the motion: None where the model states errors as large.
        """
        policy, interval_s, time_s = problem.policy, problem.state.interval_s, problem.state.time_s
        limited, unevenness = _limited(bridge_unused(time_s, after, problem.usable), policy)
        remaining, taken = (
            Bands.of(values, interval_s, policy.first_line, policy.bands) for values in (limited, before - after)
        )
        slow = int(np.searchsorted(remaining.f, 0.5 / mean_lengths_s(time_s, policy)[0]))
        power = remaining.power[slow:]
        if not _rises(power, remaining.shape[slow:] / unevenness, policy) or within_stated_errors(problem, after):
            return None
        above = np.append(np.zeros(slow), power - np.minimum.accumulate(power))
        first, last = np.flatnonzero(above > policy.quarter * above.max())[[0, -1]]
        edges = np.append(np.sqrt(remaining.f[1:] * remaining.f[:-1]), 0.5 / interval_s)
        hides = _hides(above, taken, slice(first, last + 1), policy)
        return cls(float(edges[first - 1]), float(edges[last]), hides)

    @property
    def words(self) -> str:
        """The frequency range in words."""
        return f"structure between {figure(self.low_hz, 2)} and {figure(self.high_hz, 2)} Hz"


def _hides(above: Array, taken: Bands, within: slice, policy: Policy) -> bool:
    """Whether most power of the names is in the range, and negligible beside the excess density `above` (m,)."""
    of_names, of_excess = taken.power * taken.shape, above * taken.shape
    named, rest = float(of_names[within].sum()), float(of_excess[within].sum())
    return float(of_names.sum()) / 2 < named < policy.fair_share * (named + rest)


def _limited(values: Array, policy: Policy) -> tuple[Array, float]:
    """Values (n, q) with outliers clipped, and the kurtosis of the result over a normal distribution's, at least 1."""
    most = policy.far_sigma * median_abs_deviation(values, axis=0, scale="normal")
    limited = np.clip(values - np.median(values, axis=0), -most, most)
    kurtosis = (limited**4).mean(axis=0) / np.maximum((limited**2).mean(axis=0) ** 2, 1e-300)
    return limited, max(1.0, float(kurtosis.mean()) / 3)


def _rises(power: Array, shape: Array, policy: Policy) -> bool:
    """Whether bands (m,) of gamma shape (m,) exceed, significantly, every non-increasing spectrum.

    ``G = 2 sum shape ln(S / power)``, S the likeliest non-increasing spectrum. For white noise S has l levels with the
    probability of l cycles in a permutation of m bands, and G is chi-square with m - l degrees of freedom; for falling
    spectra G is smaller.
    """
    m = len(power)
    if not (power > 0).all():
        return False
    falling = isotonic_regression(power, weights=shape, increasing=False).x
    G = 2 * float((shape * np.log(falling / power)).sum())
    cycles = np.poly(-np.arange(m))[-2::-1] / math.factorial(m)
    chance = float(cycles[:-1] @ chi2.sf(G, m - 1 - np.arange(m - 1)))
    share = float((np.maximum(power - falling, 0.0) * shape).sum() / (power * shape).sum())
    return chance < policy.spectrum_alarm and share > policy.hardly_any

"""Whiteness of a residual: block means, tones, tails, a spectrum that rises, and the level of the white noise."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import isotonic_regression
from scipy.stats import chi2, median_abs_deviation

from calib.numerics.colour import white_ratios
from diagnosis.evidence.along_field import parts_of_residual, within_stated_errors
from diagnosis.policy import Policy
from diagnosis.problem.blocks import Cut
from diagnosis.problem.linear import LinearProblem
from diagnosis.problem.motion import sample_noise
from scenarios.arrays import Array
from sim.effects import of_sign
from sim.effects.base import Effect
from validation.signals.bands import Bands
from validation.signals.tones import tones
from validation.text import figure

MOST_TONES = 5
"""Number of tones listed at most."""


@dataclass(frozen=True)
class ResidualTests:
    """Results of the tests of a residual: `why` lists the failures."""

    why: tuple[str, ...] = ()

    @property
    def clean(self) -> bool:
        """Whether every test passed."""
        return not self.why


def run_residual_tests(
    residual: Array, usable: Array, time_s: Array, fitted: int, policy: Policy, memory: int = 1, *, tails: bool = True
) -> ResidualTests:
    """Test a residual (n, q) at times (n,) in units of the noise, after a fit of `fitted` parameters.

    memory : number of samples over which a low-pass or an interpolation correlates the noise; 1: white. tails :
    whether heavy tails fail; they are the small wrong values where large ones were left out.
    """
    variance, why = _white_variance(residual, usable, fitted, memory), []
    for length_s in _mean_lengths_s(time_s, policy):
        W = _scaled_means(residual, usable, (time_s - time_s[0]) // length_s, policy) / variance
        if chi2.sf(W.sum(), W.size) < policy.test_alarm / len(policy.mean_lengths_s):
            why.append(f"means over {figure(length_s)} s vary {W.mean():.1f} times as much as white noise's")
    whole = _bridge_unused(time_s, residual, usable)
    if lines := tones(time_s, whole, false_alarm=policy.spectrum_alarm)[:MOST_TONES]:
        why.append("tones at " + ", ".join(f"{figure(line.frequency_hz, 4)} Hz" for line in lines))
    if tails and has_heavy_tails(used := residual[usable > 0], policy):
        why.append(f"heavy tails: excess kurtosis {_excess_kurtosis(used):.1f}")
    return ResidualTests(tuple(why))


def has_heavy_tails(values: Array, policy: Policy) -> bool:
    """Whether values (n, q) have larger tails than normal ones of their number."""
    return _excess_kurtosis(values) > policy.never_sigma * math.sqrt(24 / values.size) + policy.tail_excess


def _excess_kurtosis(values: Array) -> float:
    return float(((values**4).mean(axis=0) / (values**2).mean(axis=0) ** 2).mean()) - 3


def _white_variance(residual: Array, usable: Array, fitted: int, memory: int) -> Array:
    """Variance (q,) of a sample; for correlated noise, of white noise with equal slow power."""
    variance = (residual**2).sum(axis=0) / max(usable.sum() - fitted / residual.shape[1], 1)
    if memory > 1:
        cut = Cut(memory, len(residual) // memory)
        variance = variance * (cut.totals(residual) ** 2).mean() / memory / variance.mean()
    return np.asarray(variance)


def _mean_lengths_s(time_s: Array, policy: Policy) -> tuple[float, ...]:
    """The policy's averaging lengths, increased where the shortest would hold too few samples at times (n,)."""
    interval_s = float(np.median(np.diff(time_s)))
    longer = max(1.0, policy.least_mean_samples * interval_s / min(policy.mean_lengths_s))
    return tuple(longer * length_s for length_s in policy.mean_lengths_s)


def _scaled_means(residual: Array, usable: Array, cell: Array, policy: Policy) -> Array:
    """Squares (m, q) of means over the fuller cells (n,) of time, over unit white noise's; none for too few cells."""
    starts = np.flatnonzero(np.diff(cell, prepend=-1))
    count = np.add.reduceat(usable, starts)
    full = count > policy.filled_block * count.max()
    if count.max() < policy.least_mean_samples or np.count_nonzero(full) < policy.least_tested_means:
        full[:] = False
    return white_ratios(np.add.reduceat(residual, starts, axis=0)[full], count[full])


def _bridge_unused(time_s: Array, residual: Array, usable: Array) -> Array:
    """The residual (n, q) interpolated over unused samples: zeros would turn slow noise into tones."""
    used = usable > 0
    if used.all() or not used.any():
        return residual
    return np.column_stack([np.interp(time_s, time_s[used], axis[used]) for axis in residual.T])


@dataclass(frozen=True)
class RisingSpectrum:
    """Frequency range of a spectrum that rises, unlike any sensor noise, and too fast for the tested means.

    hides : the names act there and explain almost nothing of the rise.
    """

    low_hz: float
    high_hz: float
    hides: bool

    @classmethod
    def of(cls, problem: LinearProblem, before: Array, after: Array) -> RisingSpectrum | None:
        """The rise in the spectrum of a residual (n, q) after the named effects; None for a falling spectrum.

        As of a wheel or propeller with varying speed; None too where the model states attitude errors as large.
        """
        policy, interval_s, time_s = problem.policy, problem.state.interval_s, problem.state.time_s
        limited, unevenness = _limited(_bridge_unused(time_s, after, problem.usable), policy)
        remaining, taken = (
            Bands.of(values, interval_s, policy.first_line, policy.bands) for values in (limited, before - after)
        )
        slow = int(np.searchsorted(remaining.f, 0.5 / _mean_lengths_s(time_s, policy)[0]))
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


def missing_white_noise(problem: LinearProblem, residual: Array, new: Sequence[Effect]) -> Effect | None:
    """The white noise missing in the model, from the residual (n, q) with new effects; None if none is missing.

    Less rounding of the values, and less the noise that the new effects carry over from their channels.
    """
    given_nT = [effect.first_value for effect in problem.effects if effect.traits.sign == "white"]
    if not given_nT or problem.mode == "strength" or problem.relative:
        return None
    larger = problem.policy.larger
    rounding = sum(one.first_value**2 / 12 for one in (*problem.effects, *new) if one.traits.sign == "lattice")
    expected = np.maximum((np.array(given_nT) ** 2).sum(axis=0) + rounding + _brought(problem, new), 1e-12)
    seen = (sample_noise(residual) * problem.sigma_nT) ** 2
    if (seen <= larger**2 * expected).all():
        return None
    if problem.attitude_std_rad > 0 and problem.turns:  # a walk of the attitude looks white from sample to sample
        along = parts_of_residual(problem, residual)[0] / np.sqrt(problem.field_projection**2 @ expected)
        if sample_noise(along[:, None])[0] <= larger:
            return None
    return of_sign("white", np.sqrt(np.maximum(seen - expected, 0.0)).tolist())


def _brought(problem: LinearProblem, new: Sequence[Effect]) -> Array:
    """Variance (3,) in nT^2 of the white noise carried over by new effects."""
    known = [effect for effect in new if not (effect.stochastic or effect.traits.converter)]
    rng = np.random.default_rng(0)
    parts = [effect.contribution(problem.state, problem.input_nT(type(effect)), rng, {}) for effect in known]
    return sample_noise(np.sum(parts, axis=0)) ** 2 if parts else np.zeros(3)

"""Is what is left clean? Block means, tones and tails against white noise of the size that neighbours show."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from calib.numerics.colour import white_ratios
from sim.state import Array
from validation.diagnosis.policy import Policy
from validation.diagnosis.problem.blocks import Cut
from validation.signals.tones import tones

MOST_TONES = 5
"""Tones that are listed."""


@dataclass(frozen=True)
class Battery:
    """The tests of a residual: block-mean excess by length, tones found, excess kurtosis; `why` lists what failed."""

    excess: dict[float, float]
    tones_hz: tuple[float, ...]
    kurtosis: float
    why: tuple[str, ...]

    @property
    def clean(self) -> bool:
        """Whether every test passed."""
        return not self.why


def battery(residual: Array, usable: Array, interval_s: float, fitted: int, policy: Policy, memory: int = 1) -> Battery:
    """Test a residual (n, q) in units of the noise; `fitted` parameters were taken from it.

    memory : samples over which a low-pass or an interpolation colours the noise itself; 1: white.
    """
    variance = _white_variance(residual, usable, fitted, memory)
    excess, why = {}, []
    for length_s in policy.mean_lengths_s:
        scaled = _scaled_means(residual, usable, round(length_s / interval_s), variance, policy)
        if scaled is None:
            continue
        excess[length_s] = float(scaled.mean())
        if chi2.sf(scaled.sum(), max(scaled.size - fitted, 1)) < policy.means_alarm / len(policy.mean_lengths_s):
            why.append(f"means over {length_s:g} s vary {excess[length_s]:.1f} times as much as white noise's")
    time_s = np.asarray(np.arange(len(residual)) * interval_s)
    lines = tuple(one.frequency_hz for one in tones(time_s, residual, false_alarm=policy.tone_alarm)[:MOST_TONES])
    if lines:
        why.append("tones at " + ", ".join(f"{f:.4g} Hz" for f in lines))
    kurtosis = _kurtosis(residual, usable)
    if kurtosis > policy.tail_sigma * np.sqrt(24 / residual.size) + policy.tail_excess:
        why.append(f"heavy tails: excess kurtosis {kurtosis:.1f}")
    return Battery(excess, lines, kurtosis, tuple(why))


def _white_variance(residual: Array, usable: Array, fitted: int, memory: int) -> Array:
    """Variance (q,) of a sample, or where the noise has a memory that of white noise with the same slow power."""
    variance = (residual**2).sum(axis=0) / max(usable.sum() - fitted / residual.shape[1], 1)
    if memory > 1:
        cut = Cut(memory, len(residual) // memory)
        variance = variance * (cut.blocks(residual).sum(axis=1) ** 2).mean() / memory / variance.mean()
    return np.asarray(variance)


def _scaled_means(residual: Array, usable: Array, length: int, variance: Array, policy: Policy) -> Array | None:
    """Squares (m, q) of block means over their variance in white noise; None where there are too few."""
    if length < policy.least_mean_samples or len(residual) < policy.least_tested_means * length:
        return None
    cut = Cut(length, len(residual) // length)
    count = cut.blocks(usable).sum(axis=1)
    full = count > policy.filled_block * length
    if np.count_nonzero(full) < policy.least_tested_means:
        return None
    total = cut.blocks(residual).sum(axis=1)[full]
    return white_ratios(total, count[full]) / variance


def _kurtosis(residual: Array, usable: Array) -> float:
    """Excess kurtosis, mean over outputs, of the usable samples."""
    share = usable.sum() / len(usable)
    return float(np.mean((residual**4).mean(axis=0) / (residual**2).mean(axis=0) ** 2 * share) - 3)

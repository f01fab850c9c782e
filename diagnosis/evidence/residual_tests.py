"""Whiteness tests of a residual: block means, tones and tails, against the noise of neighbouring samples."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from calib.numerics.colour import white_ratios
from diagnosis.policy import Policy
from diagnosis.problem.blocks import Cut
from scenarios.arrays import Array
from validation.signals.tones import tones
from validation.text import figure

MOST_TONES = 5
"""Number of tones listed at most."""


@dataclass(frozen=True)
class ResidualTests:
    """Results of the tests: block-mean excess by length in s, tones, excess kurtosis; `why` lists the failures."""

    excess: dict[float, float]
    tones_hz: tuple[float, ...]
    kurtosis: float
    why: tuple[str, ...]

    @property
    def clean(self) -> bool:
        """Whether every test passed."""
        return not self.why


def run_residual_tests(
    residual: Array,
    usable: Array,
    time_s: Array,
    fitted: int,
    policy: Policy,
    memory: int = 1,
    *,
    tails: bool = True,
) -> ResidualTests:
    """Test a residual (n, q) at times (n,) in units of the noise, after a fit of `fitted` parameters.

    The fit may have absorbed fast or slow noise: the means are tested as if unaffected, which reduces false alarms.
    memory : number of samples over which a low-pass or an interpolation correlates the noise; 1: white. tails :
    whether heavy tails fail; they are the small wrong values where large ones were left out.
    """
    variance = _white_variance(residual, usable, fitted, memory)
    excess, why = {}, []
    for length_s in mean_lengths_s(time_s, policy):
        scaled = _scaled_means(residual, usable, _cells(time_s, length_s), policy)
        if scaled is None:
            continue
        scaled /= variance
        excess[length_s] = float(scaled.mean())
        if chi2.sf(scaled.sum(), scaled.size) < policy.test_alarm / len(policy.mean_lengths_s):
            why.append(f"means over {figure(length_s)} s vary {excess[length_s]:.1f} times as much as white noise's")
    whole = bridge_unused(time_s, residual, usable)
    lines = tuple(tone.frequency_hz for tone in tones(time_s, whole, false_alarm=policy.spectrum_alarm)[:MOST_TONES])
    if lines:
        why.append("tones at " + ", ".join(f"{figure(f, 4)} Hz" for f in lines))
    used = residual[usable > 0]
    kurtosis = float(((used**4).mean(axis=0) / (used**2).mean(axis=0) ** 2).mean()) - 3
    if tails and kurtosis > policy.never_sigma * np.sqrt(24 / residual.size) + policy.tail_excess:
        why.append(f"heavy tails: excess kurtosis {kurtosis:.1f}")
    return ResidualTests(excess, lines, kurtosis, tuple(why))


def _white_variance(residual: Array, usable: Array, fitted: int, memory: int) -> Array:
    """Variance (q,) of a sample; for correlated noise, of white noise with equal slow power."""
    variance = (residual**2).sum(axis=0) / max(usable.sum() - fitted / residual.shape[1], 1)
    if memory > 1:
        cut = Cut(memory, len(residual) // memory)
        variance = variance * (cut.blocks(residual).sum(axis=1) ** 2).mean() / memory / variance.mean()
    return np.asarray(variance)


def mean_lengths_s(time_s: Array, policy: Policy) -> tuple[float, ...]:
    """The policy's averaging lengths, increased where the shortest would hold too few samples at times (n,)."""
    interval_s = float(np.median(np.diff(time_s)))
    longer = max(1.0, policy.least_mean_samples * interval_s / min(policy.mean_lengths_s))
    return tuple(longer * length_s for length_s in policy.mean_lengths_s)


def _cells(time_s: Array, length_s: float) -> NDArray[np.int64]:
    """Time cell (n,) of each sample; a sample early by rounding of time alone belongs to the next cell."""
    return np.asarray(np.floor(np.round((time_s - time_s[0]) / length_s, 6)), dtype=np.int64)


def _scaled_means(residual: Array, usable: Array, cell: NDArray[np.int64], policy: Policy) -> Array | None:
    """Squares (m, q) of means over time cells, over their variance in unit white noise; None for too few cells.

    cell (n,): cell of each sample. Cells with less than half the samples of the fullest cell are left out.
    """
    starts = np.flatnonzero(np.diff(cell, prepend=-1))
    count = np.add.reduceat(usable, starts)
    full = count > policy.filled_block * count.max()
    if count.max() < policy.least_mean_samples or np.count_nonzero(full) < policy.least_tested_means:
        return None
    return white_ratios(np.add.reduceat(residual, starts, axis=0)[full], count[full])


def bridge_unused(time_s: Array, residual: Array, usable: Array) -> Array:
    """The residual (n, q) interpolated over unused samples: zeros would turn slow noise into tones."""
    used = usable > 0
    if used.all() or not used.any():
        return residual
    return np.column_stack([np.interp(time_s, time_s[used], axis[used]) for axis in residual.T])

"""Is what is left clean? Block means, tones and tails against white noise of the size that neighbours show."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from sim.state import Array
from validation.diagnosis.evidence.blocks import Cut
from validation.signals.tones import tones

LENGTHS_S = (1.0, 5.0, 20.0)
FALSE_ALARM = 1e-3
TONE_ALARM = 1e-4
MOST_TONES = 5


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


def battery(residual: Array, usable: Array, interval_s: float, fitted: int, memory: int = 1) -> Battery:
    """Test a residual (n, q) in units of the noise; `fitted` parameters were taken from it.

    memory : samples over which a low-pass or an interpolation colours the noise itself; 1: white.
    """
    why: list[str] = []
    excess: dict[float, float] = {}
    variance = (residual**2).sum(axis=0) / max(usable.sum() - fitted / residual.shape[1], 1)
    if memory > 1:
        cut = Cut(memory, len(residual) // memory)
        variance = variance * (cut.blocks(residual).sum(axis=1) ** 2).mean() / memory / variance.mean()
    for length_s in LENGTHS_S:
        length = round(length_s / interval_s)
        if length < 5 or len(residual) < 20 * length:
            continue
        cut = Cut(length, len(residual) // length)
        count = cut.blocks(usable).sum(axis=1)
        total = cut.blocks(residual).sum(axis=1)[count > length / 2]
        if len(total) < 20:
            continue
        scaled = total**2 / count[count > length / 2, None] / variance
        excess[length_s] = float(scaled.mean())
        if chi2.sf(scaled.sum(), max(scaled.size - fitted, 1)) < FALSE_ALARM / len(LENGTHS_S):
            why.append(f"means over {length_s:g} s vary {excess[length_s]:.1f} times as much as white noise's")
    time_s = np.asarray(np.arange(len(residual)) * interval_s)
    lines = tones(time_s, residual, false_alarm=TONE_ALARM)[:MOST_TONES]
    if lines:
        why.append("tones at " + ", ".join(f"{line.frequency_hz:.4g} Hz" for line in lines))
    share = usable.sum() / len(usable)
    kurtosis = float(np.mean((residual**4).mean(axis=0) / (residual**2).mean(axis=0) ** 2 * share) - 3)
    if kurtosis > 8 * np.sqrt(24 / residual.size) + 0.1:
        why.append(f"heavy tails: excess kurtosis {kurtosis:.1f}")
    return Battery(excess, tuple(line.frequency_hz for line in lines), kurtosis, tuple(why))

"""Structure too fast for the means that are tested: a spectrum that rises with frequency, as no sensor's noise does."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import isotonic_regression
from scipy.stats import chi2

from diagnosis.evidence.active_parts import NORMAL_MAD
from diagnosis.evidence.model_noise import as_stated
from diagnosis.evidence.residual_tests import bridged, mean_lengths_s
from diagnosis.policy import Policy
from diagnosis.problem.linear import LinearProblem
from scenarios.arrays import Array
from validation.signals.bands import Bands


@dataclass(frozen=True)
class RisingSpectrum:
    """Frequencies at which more is left than at lower ones; hides: names act there, and explain next to nothing."""

    low_hz: float
    high_hz: float
    hides: bool

    @classmethod
    def of(cls, problem: LinearProblem, before: Array, after: Array) -> RisingSpectrum | None:
        """What rises in a rest (n, q) after the names, in units of the noise; None where its spectrum only falls.

        A wheel's or a propeller's tone that sweeps with its speed is no line, and means over a second do not see it.
        What errors of the attitude leave is as fast as the motion: none is told where the model states as much.
        """
        policy, interval_s, time_s = problem.policy, problem.state.interval_s, problem.state.time_s
        limited, unevenness = _limited(bridged(time_s, after, problem.usable), policy)
        left, taken = (
            Bands.of(values, interval_s, policy.first_line, policy.bands) for values in (limited, before - after)
        )
        slow = int(np.searchsorted(left.f, 0.5 / mean_lengths_s(time_s, policy)[0]))
        if not _rises(left.power[slow:], left.shape[slow:] / unevenness, policy) or as_stated(problem, after):
            return None
        above = np.zeros(len(left.f))
        above[slow:] = left.power[slow:] - np.minimum.accumulate(left.power[slow:])
        within = _stretch(above > policy.rise_part * above.max())
        edges = np.append(np.sqrt(left.f[1:] * left.f[:-1]), 0.5 / interval_s)
        low_hz, high_hz = edges[within.start - 1], edges[within.stop - 1]
        return cls(float(low_hz), float(high_hz), _hides(above * left.shape, taken.power * left.shape, within, policy))

    @property
    def words(self) -> str:
        """Where it rises."""
        return f"structure between {self.low_hz:.2g} and {self.high_hz:.2g} Hz"


def _stretch(which: NDArray[np.bool_]) -> slice:
    """From the first to the last of bands (m,)."""
    first, last = np.flatnonzero(which)[[0, -1]]
    return slice(int(first), int(last) + 1)


def _hides(above: Array, taken: Array, within: slice, policy: Policy) -> bool:
    """Whether half of the power (m,) that names take lies within, and is next to nothing beside that above (m,)."""
    named, left = float(taken[within].sum()), float(above[within].sum())
    return float(taken.sum()) / 2 < named < policy.least_share * (named + left)


def _limited(values: Array, policy: Policy) -> tuple[Array, float]:
    """Values (n, q) without a few far ones, and by how much less even than normal ones their squares are."""
    varying = values - np.median(values, axis=0)
    most = policy.far_row * NORMAL_MAD * np.median(np.abs(varying), axis=0)
    limited = np.clip(varying, -most, most)
    kurtosis = (limited**4).mean(axis=0) / np.maximum((limited**2).mean(axis=0) ** 2, 1e-300)
    return limited, max(1.0, float(kurtosis.mean()) / 3)


def _rises(power: Array, shape: Array, policy: Policy) -> bool:
    """Whether bands (m,) of gamma shape (m,) have more power than any falling spectrum gives them by chance.

    ``G = 2 sum shape ln(S / power)``, S the likeliest falling spectrum. Of white noise, of which S has l levels with
    the chance of l cycles in a permutation of the m bands, G is chi-square of m - l degrees; of others it is less.
    """
    m = len(power)
    if not (power > 0).all():
        return False
    falling = isotonic_regression(power, weights=shape, increasing=False).x
    G = 2 * float((shape * np.log(falling / power)).sum())
    cycles = np.poly(-np.arange(m))[-2::-1] / math.factorial(m)
    chance = float(cycles[:-1] @ chi2.sf(G, m - 1 - np.arange(m - 1)))
    share = float((np.maximum(power - falling, 0.0) * shape).sum() / (power * shape).sum())
    return chance < policy.rise_alarm and share > policy.least_rise

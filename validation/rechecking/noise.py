"""Covariance of a least-squares estimate in noise that wanders, from the autocovariance of its residuals.

y_i = J_i theta + a_i n_i,  cov(n_i, n_j) = c(|i - j|) 1,  c(l) = v_0 [l = 0] + sum_j v_j exp(-l / tau_j),  v >= 0

a_i (r, 3): how noise of the three axes enters row i; noise of the field's strength enters with a = 1. The powers v are
those whose expected autocovariance of the residuals r = M y, M = 1 - J N^-1 J^T, is nearest to the measured one: what
the fit takes from slow noise is in the expectation, so that powers are not underestimated.

cov(theta) = N^-1 (sum_ij J_i^T a_i a_j^T J_j c(|i - j|)) N^-1,  N = sum_i J_i^T J_i
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls
from scipy.signal import lfilter

from scenarios.arrays import Array

TIMES = 6
"""Time constants that are tried, from one sample to the longest lag in equal ratios."""
LONGEST = 3
"""Longest lag: this part of the log; longer lags have too few pairs that are independent."""
LAGS = 40
"""Lags at which the autocovariance is taken, in equal ratios."""
LEAST_ROWS = 60
"""Rows below which no autocovariance is estimated."""
MOST_ROWS = 2000
"""Rows from which the powers are estimated; of longer logs evenly spaced rows."""


@dataclass(frozen=True, eq=False)
class WanderingFit:
    """A fit's columns J (n, r, p), entry of noise a (n, r, k) and residuals (n, r), rows in order of time."""

    J: Array
    a: Array
    r: Array

    def covariance(self, prior: Array) -> Array | None:
        """Return the covariance (p, p) of the estimate, None for too few rows; prior (p, p) : its information."""
        if len(self.r) < LEAST_ROWS:
            return None
        step = -(-len(self.r) // MOST_ROWS)
        part = WanderingFit(self.J[::step], self.a[::step], self.r[::step])
        taus, powers = part.powers(prior)
        x = self._seen(self.J)
        meat = sum(power * _between(x, tau * step) for tau, power in zip(taus, powers, strict=True))
        inverse = self._inverse(prior)
        return np.asarray(inverse @ meat @ inverse)

    def powers(self, prior: Array) -> tuple[Array, Array]:
        """Return time constants in samples, 0 for white noise, and the variance of each."""
        n = len(self.r)
        lags = np.unique(np.concatenate([[0], np.geomspace(1, n // LONGEST, LAGS).astype(int)]))
        taus = np.concatenate([[0.0], np.geomspace(1.0, n // LONGEST, TIMES)])
        s, x, inverse = np.einsum("nrk,nr->nk", self.a, self.r), self._seen(self.J), self._inverse(prior)
        outer = np.einsum("nrk,nrl->nkl", self.a, self.a).reshape(n, -1)
        pairs = _lagged(outer, outer, lags)
        design = np.column_stack([self._expected(x, outer, inverse, tau, lags, pairs) for tau in taus])
        weight = 1.0 / np.sqrt(pairs.clip(np.finfo(float).tiny))
        powers, _ = nnls(weight[:, None] * design, weight * _lagged(s, s, lags))
        return taus, powers

    def _inverse(self, prior: Array) -> Array:
        return np.asarray(np.linalg.inv(np.einsum("nrp,nrq->pq", self.J, self.J) + prior))

    def _seen(self, columns: Array) -> Array:
        """Return a^T columns (n, k, p)."""
        return np.asarray(np.einsum("nrk,nrp->nkp", self.a, columns))

    def _expected(self, x: Array, outer: Array, inverse: Array, tau: float, lags: Array, pairs: Array) -> Array:
        """Return sums over pairs at each lag of the residuals' covariance M C M, for noise of unit power.

        C - H C - C H + H C H,  H = J N^-1 J^T
        """
        n, k = x.shape[:2]
        square = outer.reshape(n, k, k)
        moved = square @ _followed(x, tau)  # a^T C J
        flat, left = x.reshape(n, -1), (moved @ inverse).reshape(n, -1)
        both = (x @ (inverse @ _between(x, tau) @ inverse)).reshape(n, -1)
        unit = (lags == 0).astype(float) if tau == 0 else np.exp(-lags / tau)
        return pairs * unit - _lagged(flat, left, lags) - _lagged(left, flat, lags) + _lagged(flat, both, lags)


def larger(one: Array, other: Array | None) -> Array:
    """Return the least covariance (p, p) that is `one`, and `other` in the directions where that is larger."""
    if other is None:
        return one
    values, axes = np.linalg.eigh(one)
    least = np.finfo(float).tiny
    root, back = axes * np.sqrt(values.clip(0.0)), (axes / np.sqrt(values.clip(least))).T
    ratio, along = np.linalg.eigh(back @ other @ back.T)
    grown = root @ along
    return np.asarray((grown * ratio.clip(1.0)) @ grown.T)


def _followed(x: Array, tau: float) -> Array:
    """Return sum_j exp(-|i - j| / tau) x_j (n, k, p); x itself for white noise."""
    if tau == 0:
        return x
    flat = x.reshape(len(x), -1)
    feedback = [1.0, -float(np.exp(-1.0 / tau))]
    forward = lfilter([1.0], feedback, flat, axis=0)
    back = lfilter([1.0], feedback, flat[::-1], axis=0)[::-1]
    return np.asarray(forward + back - flat).reshape(x.shape)


def _between(x: Array, tau: float) -> Array:
    """Return sum_ij x_i^T x_j exp(-|i - j| / tau), (p, p)."""
    return np.asarray(np.einsum("nkp,nkq->pq", x, _followed(x, tau), optimize=True))


def _lagged(x: Array, y: Array, lags: Array) -> Array:
    """Return sum_i x_i . y_i+l at each lag."""
    return np.array([float(np.einsum("nk,nk->", x[: len(x) - lag], y[lag:])) for lag in lags])

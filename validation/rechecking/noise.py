"""Covariance of a least-squares estimate in noise that wanders, by models of the noise weighted by their likelihood.

y_i = J_i theta + a_i n_i + w_i,  w white of variance s^2,  cov(n_i, n_j) = s^2 q exp(-|i - j| / tau) 1

a_i (r, k): how noise that wanders enters row i: on the sensor's axes by the surface's normal, in the field's strength
with a = 1. Each model (a, tau, q) of a grid has a restricted likelihood, in which theta and s are integrated out
[PattersonThompson1971]:

log L = -(log|V| + log|J^T V^-1 J| + (n - p) log e^T V^-1 e) / 2,  V = 1 + q a a^T exp(-|i - j| / tau)

e the generalised residual. cov(theta) of model k is N^-1 J^T (s^2 V) J N^-1, N = J^T J. A log with few independent
samples leaves several models likely; tests and intervals take all of them, weighted, as Student's t takes the variance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from scenarios.arrays import Array
from scenarios.kernel_cache import njit

TIMES = 6
"""Time constants of the grid, from one sample to LONGEST of the log in equal ratios."""
LONGEST = 1 / 3
"""Longest time constant, as a part of the log: what is slower is an offset of this log."""
RATIOS = tuple(float(q) for q in np.geomspace(1e-3, 30.0, 7))
"""Power of the noise that wanders over the white noise's, q: the grid's values."""
MOST_ROWS = 4000
"""Rows from which the likelihood is computed; of longer logs evenly spaced rows."""
UNLIKELY = 1e-6
"""Weight below which a model is left out."""


@dataclass(frozen=True, eq=False)
class WeightedCovariances:
    """Covariances (k, p, p) of an estimate by models of the noise, and the models' weights (k,), of sum 1."""

    weights: Array
    covariances: Array

    @property
    def mean(self) -> Array:
        """Return the covariance (p, p) of the mixture."""
        return np.asarray(np.tensordot(self.weights, self.covariances, 1))


@dataclass(frozen=True, eq=False)
class WanderingFit:
    """A fit's columns J (n, r, p) and residuals (n, r), rows in order of time, and the ways of noise a (n, r, k)."""

    J: Array
    r: Array
    ways: Sequence[Array]

    def covariances(self, prior: Array) -> WeightedCovariances:
        """Return the covariance of the estimate by each model that is not unlikely; prior (p, p) : its information."""
        inverse = np.asarray(np.linalg.inv(np.einsum("nrp,nrq->pq", self.J, self.J) + prior))
        step = -(-len(self.r) // MOST_ROWS)
        rows = np.ascontiguousarray(np.concatenate([self.J, self.r[:, :, None]], axis=2)[::step])
        taus = np.geomspace(1.0, max(LONGEST * len(rows), 2.0), TIMES)
        white = _between(self.J, 0.0)
        log, meat = [], []
        for a in self.ways:
            seen = np.asarray(np.einsum("nrk,nrp->nkp", a, self.J))
            thin = np.ascontiguousarray(a[::step])
            for tau in taus:
                slow = _between(seen, tau * step)
                for q in RATIOS:
                    likelihood, white_nT2 = _restricted(rows, thin, tau, q, prior)
                    log.append(likelihood)
                    meat.append(white_nT2 * (white + q * slow))
        weights = np.exp(np.array(log) - max(log))
        weights /= weights.sum()
        kept = weights > UNLIKELY
        covariances = inverse @ np.array(meat)[kept] @ inverse
        return WeightedCovariances(weights[kept] / weights[kept].sum(), covariances)


def larger(one: Array, other: Array) -> Array:
    """Return the least covariance (p, p) that is `one`, and `other` in the directions where that is larger."""
    values, axes = np.linalg.eigh(one)
    least = np.finfo(float).tiny
    root, back = axes * np.sqrt(values.clip(0.0)), (axes / np.sqrt(values.clip(least))).T
    ratio, along = np.linalg.eigh(back @ other @ back.T)
    grown = root @ along
    return np.asarray((grown * ratio.clip(1.0)) @ grown.T)


def _restricted(rows: Array, a: Array, tau: float, q: float, prior: Array) -> tuple[float, float]:
    """Return the log of the restricted likelihood, and s^2, of rows (n, r, p + 1): columns and residual."""
    gram, logdet = _whitened(rows, a, float(np.exp(-1.0 / tau)), q)
    information = gram[:-1, :-1] + prior
    left = float(gram[-1, -1] - gram[:-1, -1] @ np.linalg.solve(information, gram[:-1, -1]))
    free = max(rows.shape[0] * rows.shape[1] - len(prior), 1)
    left = max(left, float(np.finfo(float).tiny))
    return -0.5 * (logdet + float(np.linalg.slogdet(information)[1]) + free * float(np.log(left))), left / free


@njit(cache=True, fastmath={"reassoc", "contract"})
def _whitened(rows: Array, a: Array, kept: float, q: float) -> tuple[Array, float]:
    """X^T V^-1 X (c, c) of rows X (n, r, c), and log|V|, by a Kalman filter of the noise n (k,), kept = exp(-1 / tau).

    The c columns are filtered with the same gains, so that their innovations are the whitened columns.
    """
    n, r, c = rows.shape
    k = a.shape[2]
    state, P, gram, logdet = np.zeros((k, c)), q * np.eye(k), np.zeros((c, c)), 0.0
    e, Pa = np.empty(c), np.empty(k)
    for i in range(n):
        state *= kept
        for u in range(k):
            for v in range(k):
                P[u, v] *= kept * kept
            P[u, u] += (1.0 - kept * kept) * q
        for j in range(r):
            f = 1.0
            for u in range(k):
                Pa[u] = 0.0
                for v in range(k):
                    Pa[u] += P[u, v] * a[i, j, v]
                f += a[i, j, u] * Pa[u]
            for m in range(c):
                e[m] = rows[i, j, m]
                for u in range(k):
                    e[m] -= a[i, j, u] * state[u, m]
            for m in range(c):
                for u in range(k):
                    state[u, m] += Pa[u] * e[m] / f
                for o in range(m + 1):
                    gram[m, o] += e[m] * e[o] / f
            for u in range(k):
                for v in range(k):
                    P[u, v] -= Pa[u] * Pa[v] / f
            logdet += np.log(f)
    for m in range(c):
        for o in range(m):
            gram[o, m] = gram[m, o]
    return gram, logdet


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

"""Exact likelihood and innovations of a slow disturbance under a given spectrum, from steps between block means."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import toeplitz
from scipy.optimize import minimize_scalar
from scipy.stats import chi2

from diagnosis.policy import Policy
from diagnosis.problem.blocks import Cut
from scenarios.arrays import Array

LOG_SIZES = (-14.0, 14.0)
"""Range of the logarithm of the slow noise's size over the power of the white noise, in the search."""
Density = Callable[[Array], Array]


@dataclass(frozen=True)
class Steps:
    """Steps (n, q) between means over blocks of `block_s`, of a residual in units of the noise."""

    values: Array
    block_s: float

    @classmethod
    def of(cls, residual: Array, interval_s: float, policy: Policy) -> Steps:
        """Steps of a residual (n, q) between blocks of `step_s`, adapted to give `least_steps` to `most_steps`."""
        n = len(residual)
        length = max(1, min(round(policy.step_s / interval_s), n // policy.least_steps), n // policy.most_steps)
        return cls(np.diff(Cut(length, n // length).means(residual), axis=0), length * interval_s)

    def correlation(self, density: Density) -> Array:
        """``r_k = int S(f) sinc^2(f T) 4 sin^2(pi f T) cos(2 pi f k T) df`` (n,) of the steps under a spectrum S."""
        n, T = len(self.values), self.block_s
        f = np.asarray((np.arange(32 * n) + 0.5) / (8 * n * T), dtype=np.float64)
        power = density(f) * np.sinc(f * T) ** 2 * 4 * np.sin(np.pi * f * T) ** 2 / (8 * n * T)
        return np.array([power @ np.cos(2 * np.pi * f * k * T) for k in range(n)])

    def fit(self, level: float, shape: Density | None) -> tuple[float, Array, Array]:
        """Log-likelihood, size s (q,) of each axis and innovations (n, q) under ``S = level + s shape``."""
        white = self.correlation(lambda f: np.full(len(f), level))
        slow = np.zeros(len(white)) if shape is None else self.correlation(shape)
        parts = [_axis(column, white, slow) for column in self.values.T]
        return sum(p[0] for p in parts), np.array([p[1] for p in parts]), np.stack([p[2] for p in parts], axis=1)


def _axis(steps: Array, white: Array, slow: Array) -> tuple[float, float, Array]:
    """Log-likelihood, size and innovations (n,) of one axis."""
    if not slow.any():
        score, z = _likelihood(steps, white)
        return score, 0.0, z
    scale = white[0] / slow[0]
    best = minimize_scalar(
        lambda x: -_likelihood(steps, white + np.exp(x) * scale * slow)[0], bounds=LOG_SIZES, method="bounded",
        options={"xatol": 0.05, "maxiter": 25},
    )  # fmt: skip
    size = float(np.exp(best.x) * scale)
    score, z = _likelihood(steps, white + size * slow)
    return score, size, z


def _likelihood(steps: Array, row: Array) -> tuple[float, Array]:
    factor = np.linalg.cholesky(toeplitz(row))
    z: Array = np.asarray(np.linalg.solve(factor, steps), dtype=np.float64)
    return float(-np.log(np.diag(factor)).sum() - (z**2).sum() / 2), z


def is_random(innovations: Array, policy: Policy) -> bool:
    """Whether innovations (n, q) have no isolated jump, no steady trend and no significant slow oscillation."""
    z = innovations / innovations.std(axis=0)
    n, q = z.shape
    beyond = np.concatenate([np.zeros((1, q)), np.cumsum(z, axis=0)])
    courses = [np.abs(beyond[w:] - beyond[:-w]).max() / np.sqrt(w) for w in 2 ** np.arange(int(np.log2(n)) + 1)]
    swings = np.array([(z[lag:] * z[:-lag]).sum() ** 2 / (n - lag) / q for lag in range(1, policy.swing_lags + 1)])
    return bool(max(courses) < policy.far_sigma and chi2.sf(swings.sum(), policy.swing_lags) > policy.test_alarm)

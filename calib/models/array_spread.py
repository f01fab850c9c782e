"""How sure an array's parameters are: noise from the residual, and the covariance that white noise gives them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from calib.models.sensor_array import ArrayObjective, corrected, free_parameters, maps, residual_size, residuals
from scenarios.arrays import Array

MAX_CONDITION = 1e13
ROUNDING = 1e-11
"""Smallest noise, as a fraction of the field: rounding."""
MOST_SAMPLES = 1000
"""At most so many samples, evenly taken, tell the covariance's shape."""
STEP = 1e-5


@dataclass(frozen=True, eq=False)
class Spread:
    """Noise on each axis and root of the objective, both over F; covariance (q, q) of a vector's free parameters.

    The covariance is None when the parameters cannot be distinguished.
    """

    noise: float
    rms: float
    covariance: Array | None

    @classmethod
    def of(cls, task: ArrayObjective, p: Array) -> Spread:
        """Linearised at parameters p (12 k,), for residuals r_t = r_t(p) + D_t w_t with white w_t of variance s^2.

        cov = s^2 H^-1 (sum_t J_t^T D_t D_t^T J_t) H^-1,  H = sum_t J_t^T J_t,  J_t = d r_t / d p
        s^2 = sum |r_t|^2 / (sum tr D_t D_t^T - tr H^-1 sum_t J_t^T D_t D_t^T J_t)
        """
        rms = math.sqrt(residuals(p, task, np.empty(residual_size(task))))
        used = task._replace(field=task.field[:, :: -(-task.field.shape[1] // MOST_SAMPLES)])
        jacobian, noise = _jacobian(used, p), _noise_map(used, p)
        power = float((noise**2).sum()) / len(noise)
        inverse = _inverse_information(jacobian)
        if inverse is None:
            return cls(rms / math.sqrt(power), rms, None)
        mixed = (jacobian.transpose(0, 2, 1) @ noise).transpose(1, 0, 2).reshape(len(inverse), -1)
        meat, n = mixed @ mixed.T / len(noise), task.field.shape[1]
        variance = max(rms**2 / (power - float(np.trace(inverse @ meat)) / n), ROUNDING**2)
        covariance = variance / n * inverse @ meat @ inverse
        return cls(math.sqrt(variance), rms, (covariance + covariance.T) / 2)


def _inverse_information(jacobian: Array) -> Array | None:
    """H^-1 (q, q) of Jacobians (n, r, q), a sample's mean; None when the parameters cannot be distinguished."""
    rows = jacobian.reshape(-1, jacobian.shape[2])
    H = rows.T @ rows / len(jacobian)
    size = np.sqrt(np.diag(H)) + np.finfo(float).tiny
    if np.linalg.cond(H / np.outer(size, size)) > MAX_CONDITION:
        return None
    return np.asarray(np.linalg.inv(H))


def sample_residuals(task: ArrayObjective, p: Array) -> Array:
    """The residuals (n, k + 3 pairs) behind the objective, sample by sample: totals, then weighted differences."""
    h = corrected(p, task.field)
    totals = ((h**2).sum(axis=2) - 1.0) / 2.0
    i, j = task.pairs.T
    differences = task.weight[:, None, :] * (h[i] - h[j])
    return np.concatenate((totals.T, differences.transpose(1, 0, 2).reshape(h.shape[1], -1)), axis=1)


def _noise_map(task: ArrayObjective, p: Array) -> Array:
    """D (n, k + 3 pairs, 3 k): what noise on the k sensors' axes does to the residuals."""
    k, n = task.field.shape[:2]
    matrix, _ = maps(p, k)
    h = corrected(p, task.field)
    out = np.zeros((n, k + 3 * len(task.pairs), 3 * k))
    for i in range(k):
        out[:, i, 3 * i : 3 * i + 3] = h[i] @ matrix[i]
    for e, (i, j) in enumerate(task.pairs):
        rows = slice(k + 3 * e, k + 3 * e + 3)
        out[:, rows, 3 * i : 3 * i + 3] = task.weight[e][:, None] * matrix[i]
        out[:, rows, 3 * j : 3 * j + 3] = -task.weight[e][:, None] * matrix[j]
    return out


def _jacobian(task: ArrayObjective, p: Array) -> Array:
    """d residual / d free parameter (n, k + 3 pairs, q), by central differences."""
    columns = []
    for index in free_parameters(len(task.field)):
        step = np.zeros(len(p))
        step[index] = STEP
        columns.append((sample_residuals(task, p + step) - sample_residuals(task, p - step)) / (2 * STEP))
    return np.stack(columns, axis=2)

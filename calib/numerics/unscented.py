"""The unscented Kalman filter of a constant state on a squared strength: compiled, and by filterpy, whose results it
gives.

State x (9,) = (d, D), D symmetric by its upper triangle; observation |(I + D) m - d|^2 / 2 of a measurement m (3,).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from calib.numerics.kalman import Engine
from scenarios.arrays import Array
from scenarios.kernel_cache import njit

STATES = 9
CENTRE_WEIGHT = 2.0
"""Of the middle point in a covariance, 1 - alpha^2 + beta with alpha = 1, beta = 2; in a mean it has none."""
POINT_WEIGHT = 1.0 / (2 * STATES)
"""Of each other point, 1 / (2 (n + lambda)) with lambda = alpha^2 (n + kappa) - n = 0. [VanDerMerwe2004]"""


def half_square(state: Array, m: Array) -> Array:
    """|(I + D) m - d|^2 / 2 (n,) of a state (9,) and measurements (n, 3), all in units of F."""
    out = np.empty(len(m))
    _half_squares(state, np.ascontiguousarray(m), out)
    return out


@njit(cache=True)
def _half_squares(state: Array, m: Array, out: Array) -> None:
    xx, xy, xz, yy, yz, zz = state[3:]
    for i in range(len(m)):
        a, b, c = m[i]
        x = a + xx * a + xy * b + xz * c - state[0]
        y = b + xy * a + yy * b + yz * c - state[1]
        z = c + xz * a + yz * b + zz * c - state[2]
        out[i] = 0.5 * (x * x + y * y + z * z)


@njit(cache=True)
def _run(blocks: Array, start: Array, prior: Array, noise: float) -> tuple[Array, Array, float]:
    """For each block: sigma points of (x, P), their observations' mean and covariance, then the usual update."""
    size = blocks.shape[1]
    x, P, total = start.copy(), prior.copy(), 0.0
    points, seen = np.empty((2 * STATES + 1, STATES)), np.empty((2 * STATES + 1, size))
    weights = np.full(2 * STATES + 1, POINT_WEIGHT)
    weights[0] = CENTRE_WEIGHT
    for block in blocks:
        root = np.linalg.cholesky(STATES * P)
        points[:] = x
        for k in range(STATES):
            points[1 + k] += root[:, k]
            points[1 + STATES + k] -= root[:, k]
        for k in range(2 * STATES + 1):
            _half_squares(points[k], block, seen[k])
        mean = np.zeros(size)
        for k in range(1, 2 * STATES + 1):
            mean += POINT_WEIGHT * seen[k]
        off = seen - mean
        weighted = off * weights.reshape(-1, 1)
        S = off.T @ weighted + noise**2 * np.eye(size)
        inverse = np.linalg.inv(S)
        K = (points - x).T @ weighted @ inverse
        innovation = 0.5 - mean
        x = x + K @ innovation
        P = P - K @ S @ K.T
        P = (P + P.T) / 2
        total += float(innovation @ inverse @ innovation)
    return x, P, total / (size * len(blocks))


def _run_by_filterpy(blocks: Array, start: Array, prior: Array, noise: float) -> tuple[Array, Array, float]:
    """The same by filterpy's predict and update, its P made symmetric after each."""
    # Imported here: filterpy takes more than a second that other methods need not wait for.
    from filterpy.kalman import MerweScaledSigmaPoints, UnscentedKalmanFilter

    size = blocks.shape[1]
    points = MerweScaledSigmaPoints(STATES, alpha=1.0, beta=2.0, kappa=0.0)
    filter_ = UnscentedKalmanFilter(STATES, size, 1.0, hx=half_square, fx=lambda x, dt: x, points=points)
    filter_.x, filter_.P, filter_.Q = start.copy(), prior, np.zeros((STATES, STATES))
    filter_.R = np.eye(size) * noise**2
    total = 0.0
    for block in blocks:
        filter_.predict()
        filter_.update(np.full(size, 0.5), m=block)
        filter_.P = (filter_.P + filter_.P.T) / 2
        total += float(filter_.y @ filter_.SI @ filter_.y)
    return np.asarray(filter_.x), np.asarray(filter_.P), total / (size * len(blocks))


Found = tuple[Array, Array, float]
ENGINES: dict[Engine, Callable[[Array, Array, Array, float], Found]] = {"compiled": _run, "filterpy": _run_by_filterpy}


def filtered(blocks: Array, start: Array, prior: Array, noise: float, engine: Engine = "compiled") -> Found:
    """One run along blocks (b, n, 3): state (9,), covariance (9, 9), mean squared innovation over its expectation."""
    return ENGINES[engine](np.ascontiguousarray(blocks), start, prior, noise)

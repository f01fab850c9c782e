"""The Kalman filter of a constant state: compiled, and by filterpy, whose results it gives."""

from __future__ import annotations

from typing import Any, Literal, NamedTuple

import numpy as np

from scenarios.arrays import Array
from scenarios.kernel_cache import njit

Engine = Literal["compiled", "filterpy"]


class NoiseRule(NamedTuple):
    """How the measurement's variance follows the innovations: R <- max(s R, floor), s = factors at the ratio ROR.

    ROR = tr(mean of r r^T over the last `window` innovations) / tr(H P H^T + R). `factors` are held evenly from the
    ratio `low` on, `per_ratio` of them to a unit of it, and constant beyond; a window of 0 leaves R as it is.
    """

    factors: Array
    low: float
    per_ratio: float
    window: int
    floor: float


STEADY = NoiseRule(np.ones(1), 0.0, 0.0, 0, 0.0)
"""R stays."""


class Run(NamedTuple):
    """A filter along n samples of m values and a state of d: state and variance (n, d), innovation (n, m) and its
    covariance's inverse (n, m, m) and trace predicted (n,), R noise (n,); covariance (d, d) of the last state."""

    state: Array
    variance: Array
    innovation: Array
    inverse: Array
    predicted: Array
    noise: Array
    covariance: Array

    @classmethod
    def empty(cls, n: int, m: int, d: int) -> Run:
        """To be filled."""
        shapes = ((n, d), (n, d), (n, m), (n, m, m), (n,), (n,), (d, d))
        return cls(*(np.empty(shape) for shape in shapes))


@njit(cache=True)
def step(x: Array, P: Array, y: Array, H: Array, Q: Array, R: Array) -> tuple[Any, ...]:
    """State (d,) and covariance (d, d) after a sample y (m,) = H x + v; innovation, its covariance and the inverse.

    P is made symmetric: where P H H^T / R is near 1e14, rounding otherwise makes it indefinite.
    """
    P = P + Q
    r = y - H @ x
    S = H @ P @ H.T + R
    inverse = np.linalg.inv(S)
    K = P @ H.T @ inverse
    A = np.eye(len(x)) - K @ H
    P = A @ P @ A.T + K @ R @ K.T
    return x + K @ r, (P + P.T) / 2, r, S, inverse


@njit(cache=True)
def next_noise(
    rule: NoiseRule, squares: Array, k: int, total: float, predicted: float, noise: float
) -> tuple[float, float]:
    """Sum of the squared innovations in the window after sample k, from that before it, and R of the next sample."""
    total = total + squares[k] - (squares[k - rule.window] if k >= rule.window else 0.0)
    if k + 1 < rule.window:
        return total, noise
    place = int(np.rint((total / rule.window / predicted - rule.low) * rule.per_ratio))
    factor = rule.factors[min(max(place, 0), len(rule.factors) - 1)]
    return total, max(noise * factor, rule.floor)


@njit(cache=True)
def _run(y: Array, H: Array, x: Array, P: Array, Q: Array, noise: float, rule: NoiseRule, run: Run) -> None:
    """Fill the run with filtered samples y (n, m), H (n, m, d)."""
    squares, total, unit = np.empty(len(y)), 0.0, np.eye(y.shape[1])
    for k in range(len(y)):
        x, P, r, S, inverse = step(x, P, y[k], H[k], Q, noise * unit)
        run.state[k], run.variance[k], run.innovation[k], run.inverse[k] = x, np.diag(P), r, inverse
        run.predicted[k], run.noise[k], squares[k] = np.trace(S), noise, r @ r
        if rule.window > 0:
            total, noise = next_noise(rule, squares, k, total, run.predicted[k], noise)
    run.covariance[:] = P


def _run_by_filterpy(y: Array, H: Array, x: Array, P: Array, Q: Array, noise: float, rule: NoiseRule, run: Run) -> None:
    """The same by filterpy's predict and update, its P made symmetric after each."""
    # Imported here: filterpy takes more than a second that other methods need not wait for.
    from filterpy.kalman import KalmanFilter

    filter_ = KalmanFilter(dim_x=len(x), dim_z=y.shape[1])
    filter_.x, filter_.P, filter_.Q = x.copy(), P.copy(), Q
    squares, total, unit = np.empty(len(y)), 0.0, np.eye(y.shape[1])
    for k in range(len(y)):
        filter_.predict()
        filter_.update(y[k], R=noise * unit, H=H[k])
        filter_.P = (filter_.P + filter_.P.T) / 2
        run.state[k], run.variance[k] = filter_.x, np.diag(filter_.P)
        run.innovation[k], run.inverse[k] = filter_.y, filter_.SI
        run.predicted[k], run.noise[k], squares[k] = np.trace(filter_.S), noise, filter_.y @ filter_.y
        if rule.window > 0:
            total, noise = next_noise(rule, squares, k, total, run.predicted[k], noise)
    run.covariance[:] = filter_.P


ENGINES = {"compiled": _run, "filterpy": _run_by_filterpy}


def filtered(
    y: Array,
    H: Array,
    start: Array,
    prior: Array,
    Q: Array,
    noise: float,
    rule: NoiseRule = STEADY,
    engine: Engine = "compiled",
) -> Run:
    """Filter y_k (n, m) = H_k x_k + v, H (n, m, d), x_k = x_(k-1) + w, from a start (d,) and prior (d, d).

    P += Q,  K = P H^T (H P H^T + R)^-1,  x += K (y - H x),  P = (I - K H) P (I - K H)^T + K R K^T,  R = noise I
    """
    run = Run.empty(len(y), y.shape[1], len(start))
    ENGINES[engine](np.ascontiguousarray(y), np.ascontiguousarray(H), start, prior, Q, noise, rule, run)
    return run

"""The Kalman filter of a constant state: compiled, and by filterpy, whose results it gives."""

from __future__ import annotations

from typing import Literal, NamedTuple

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


@njit(cache=True, fastmath={"contract"})
def _times(left: Array, right: Array, out: Array) -> None:
    """out = left right, (m, j), (j, d) and (m, d), row by row; most of H is zero, and costs nothing."""
    for a in range(left.shape[0]):
        for i in range(right.shape[1]):
            out[a, i] = 0.0
        for j in range(right.shape[0]):
            factor = left[a, j]
            if factor != 0.0:
                for i in range(right.shape[1]):
                    out[a, i] += factor * right[j, i]


@njit(cache=True, fastmath={"contract"})
def _take_off(P: Array, left: Array, right: Array) -> None:
    """P -= left^T right, (d, d), (m, d) and (m, d)."""
    for a in range(len(left)):
        for j in range(len(P)):
            factor = left[a, j]
            for i in range(len(P)):
                P[j, i] -= factor * right[a, i]


@njit(cache=True)
def _invert(S: Array, out: Array) -> None:
    """out = S^-1 of a positive definite S (m, m), by Gauss-Jordan in place; ZeroDivisionError for a singular one."""
    m = len(S)
    out[:] = S
    for k in range(m):
        pivot = 1.0 / out[k, k]
        out[k, k] = 1.0
        for j in range(m):
            out[k, j] *= pivot
        for i in range(m):
            if i != k:
                factor, out[i, k] = out[i, k], 0.0
                for j in range(m):
                    out[i, j] -= factor * out[k, j]


@njit(cache=True)
def _make_symmetric(P: Array) -> None:
    """P <- (P + P^T) / 2: where P H H^T / R is near 1e14, rounding otherwise makes P indefinite."""
    for i in range(len(P)):
        for j in range(i):
            P[i, j] = P[j, i] = (P[i, j] + P[j, i]) / 2


@njit(cache=True)
def step(
    x: Array, P: Array, H: Array, noise: float, r: Array, S: Array, inverse: Array, work: tuple[Array, ...]
) -> None:
    """Move x (d,) and P (d, d), which holds Q already, by a sample with innovation r (m,), in place; fill S and S^-1.

    B = (I - K H) P = P - K (H P),  P <- B (I - K H)^T + K R K^T = B - (B H^T - K R) K^T, with B^T in place of P.
    work: three arrays (m, d), for H P, K^T and (B H^T - K R)^T.
    """
    of_P, gain, rest = work
    _times(H, P, of_P)
    for a in range(len(r)):
        for b in range(len(r)):
            S[a, b] = noise if a == b else 0.0
            for i in range(len(x)):
                S[a, b] += of_P[a, i] * H[b, i]
    _invert(S, inverse)
    _times(inverse.T, of_P, gain)
    _take_off(P, of_P, gain)
    _times(H, P, rest)
    for a in range(len(r)):
        for i in range(len(x)):
            rest[a, i] -= noise * gain[a, i]
            x[i] += gain[a, i] * r[a]
    _take_off(P, gain, rest)
    _make_symmetric(P)


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
    """Fill the run with filtered samples y (n, m), H (n, m, d), without an allocation a sample."""
    (n, m), d = y.shape, len(x)
    x, P, S, squares, total = x.copy(), P.copy(), np.empty((m, m)), np.empty(n), 0.0
    work = np.empty((m, d)), np.empty((m, d)), np.empty((m, d))
    for k in range(n):
        P += Q
        run.predicted[k], run.noise[k], squares[k] = 0.0, noise, 0.0
        for a in range(m):
            run.innovation[k, a] = y[k, a]
            for i in range(d):
                run.innovation[k, a] -= H[k, a, i] * x[i]
            squares[k] += run.innovation[k, a] ** 2
        step(x, P, H[k], noise, run.innovation[k], S, run.inverse[k], work)
        for a in range(m):
            run.predicted[k] += S[a, a]
        for i in range(d):
            run.state[k, i], run.variance[k, i] = x[i], P[i, i]
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

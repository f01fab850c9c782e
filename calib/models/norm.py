"""The norm residual |T x - c| - 1 with its exact gradient and Hessian, and how sure its minimum is.

T is symmetric and p the norm coordinates of `calib.models.ellipsoid`: y = T x - c is linear in p, and |y| = 1 where
|h| = F.
"""

from __future__ import annotations

import numpy as np

from calib.models.ellipsoid import SLOTS, UPPER, EllipsoidFit, mean_square_error, symmetric
from scenarios.arrays import Array
from scenarios.kernel_cache import njit


@njit(cache=True)
def corrected(p: Array, x: Array, k: int) -> tuple[float, float, float]:
    """y = T x_k - c of point k."""
    a, b, d = x[k, 0], x[k, 1], x[k, 2]
    return (
        p[0] * a + p[1] * b + p[2] * d - p[6],
        p[1] * a + p[3] * b + p[4] * d - p[7],
        p[2] * a + p[4] * b + p[5] * d - p[8],
    )


@njit(cache=True)
def norm_cost(p: Array, x: Array) -> float:
    """f(p) = sum_i (|T x_i - c| - 1)^2."""
    total = 0.0
    for k in range(len(x)):
        u, v, w = corrected(p, x, k)
        total += (np.sqrt(u * u + v * v + w * w) - 1.0) ** 2
    return total


@njit(cache=True)
def norm_sums(p: Array, x: Array) -> tuple[float, Array, Array, Array]:
    """f, the sums of r q (9,) and q q^T / |y| (9, 9; upper triangle), and the moments of (x, 1) weighted by r / |y|.

    r = |y| - 1,  u = y / |y|,  q = d|y| / dp
    """
    gradient, outer, moments = np.zeros(9), np.zeros((9, 9)), np.zeros((4, 4))
    q, one = np.empty(9), np.ones(4)
    total = 0.0
    for k in range(len(x)):
        a, b, d = x[k, 0], x[k, 1], x[k, 2]
        u, v, w = corrected(p, x, k)
        inverse = 1.0 / max(np.sqrt(u * u + v * v + w * w), 1e-300)
        r = 1.0 / inverse - 1.0
        u, v, w = u * inverse, v * inverse, w * inverse
        q[0], q[1], q[2] = u * a, u * b + v * a, u * d + w * a
        q[3], q[4], q[5] = v * b, v * d + w * b, w * d
        q[6], q[7], q[8] = -u, -v, -w
        one[0], one[1], one[2] = a, b, d
        total += r * r
        for i in range(9):
            gradient[i] += r * q[i]
            scaled = inverse * q[i]
            for j in range(i, 9):
                outer[i, j] += scaled * q[j]
        for i in range(4):
            for j in range(i, 4):
                moments[i, j] += r * inverse * one[i] * one[j]
    return total, gradient, outer, moments


def norm_derivatives(p: Array, x: Array) -> tuple[float, Array, Array]:
    """f(p) = sum_i (|T x_i - c| - 1)^2, its gradient (9,) and Hessian (9, 9), exact.

    df = 2 sum r q,  d2f = 2 sum [ q q^T / |y| + (1 - 1/|y|) Y^T Y ],  Y = dy/dp (3, 9),  q = Y^T y / |y|
    """
    f, gradient, outer, moments = norm_sums(p, x)
    upper = np.triu(outer) + np.triu(outer, 1).T
    full = np.triu(moments) + np.triu(moments, 1).T
    hessian = upper + np.einsum("ipk,iql,kl->pq", SLOTS, SLOTS, full)
    return f, 2 * gradient, 2 * hessian


def norm_rows(p: Array, x: Array) -> tuple[Array, Array]:
    """r (n,) = |y| - 1 and its derivative q (n, 9) = d|y| / dp."""
    y = x @ symmetric(p[:6]) - p[6:]
    length = np.sqrt(np.einsum("ni,ni->n", y, y))
    u = y / length[:, None]
    i, j = UPPER
    pairs = u[:, i] * x[:, j] + np.where(i == j, 0.0, u[:, j] * x[:, i])
    return length - 1.0, np.concatenate((pairs, -u), axis=1)


def norm_fit(p: Array, x: Array, history: tuple[float, ...]) -> EllipsoidFit:
    """The ellipsoid of a minimum p, and its mean square error by noise of equal strength on the components of x.

    H = half the Hessian,  M = sum |T u|^2 q q^T,  bias = -sum E[r q],  sigma^2 = sum r^2 / (mean |T u|^2 (n - 9))

    The bias: the cost falls when T shrinks the noise with the points, which a motion that excites an axis weakly does
    not prevent.
    """
    f, _, hessian = norm_derivatives(p, x)
    steep, outer, expected = noise_sums(p, x)
    variance = f / (steep / len(x) * max(len(x) - 9, 1))
    meat = np.triu(outer) + np.triu(outer, 1).T
    error = mean_square_error(hessian / 2, variance, meat, expected)
    return EllipsoidFit.of_norm(p, error, float(np.sqrt(variance)), history)


@njit(cache=True)
def noise_sums(p: Array, x: Array) -> tuple[float, Array, Array]:
    """sum |T u|^2, sum |T u|^2 q q^T (9, 9; upper triangle) and sum E[r q] (9,) for noise of variance one on x.

    r and q vary together, and r has a mean:  E[r q] = q(u, T u; no c) + q(P T T u, x) / |y|
    + (|T|^2 - |T u|^2) / (2 |y|) q(u, x),  q(a, x) = Y(x)^T a,  P = I - u u^T
    """
    size = p[0] ** 2 + p[3] ** 2 + p[5] ** 2 + 2.0 * (p[1] ** 2 + p[2] ** 2 + p[4] ** 2)
    outer, expected = np.zeros((9, 9)), np.zeros(9)
    q, varied, turned = np.empty(9), np.empty(9), np.empty(9)
    u, lean, across = np.empty(3), np.empty(3), np.empty(3)
    total = 0.0
    for k in range(len(x)):
        u[0], u[1], u[2] = corrected(p, x, k)
        length = np.sqrt(u[0] ** 2 + u[1] ** 2 + u[2] ** 2)
        for i in range(3):
            u[i] /= length
        _turned(p, u, lean)
        _turned(p, lean, across)
        steep = lean[0] ** 2 + lean[1] ** 2 + lean[2] ** 2
        along = u[0] * across[0] + u[1] * across[1] + u[2] * across[2]
        for i in range(3):
            across[i] = (across[i] - u[i] * along) / length
        _through(u, x[k], q)
        _through(u, lean, varied)
        _through(across, x[k], turned)
        mean = (size - steep) / (2.0 * length)
        total += steep
        for i in range(9):
            expected[i] += (varied[i] if i < 6 else 0.0) + turned[i] + mean * q[i]
            for j in range(i, 9):
                outer[i, j] += steep * q[i] * q[j]
    return total, outer, expected


@njit(cache=True)
def _turned(p: Array, x: Array, out: Array) -> None:
    """T x (3,) into out."""
    out[0] = p[0] * x[0] + p[1] * x[1] + p[2] * x[2]
    out[1] = p[1] * x[0] + p[3] * x[1] + p[4] * x[2]
    out[2] = p[2] * x[0] + p[4] * x[1] + p[5] * x[2]


@njit(cache=True)
def _through(a: Array, x: Array, out: Array) -> None:
    """Y(x)^T a (9,) into out."""
    out[0], out[1], out[2] = a[0] * x[0], a[0] * x[1] + a[1] * x[0], a[0] * x[2] + a[2] * x[0]
    out[3], out[4], out[5] = a[1] * x[1], a[1] * x[2] + a[2] * x[1], a[2] * x[2]
    out[6], out[7], out[8] = -a[0], -a[1], -a[2]

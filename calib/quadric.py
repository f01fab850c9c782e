"""Quadric surfaces in noisy points: design rows, their noise, fits, and the ellipsoid's centre and shape.

Q(x) = theta . xi(x) = a x^2 + b y^2 + c z^2 + 2 f yz + 2 g xz + 2 h xy + 2 p x + 2 q y + 2 r z + d,
theta = (a, b, c, f, g, h, p, q, r, d).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
ROUNDING_VARIANCE = 1e-18
"""Smallest noise variance of points of unit size: rounding, 1e-9 of their size."""


def design(x: Array) -> Array:
    """Rows xi(x) without the constant: (n, 9) for points (n, 3)."""
    return np.concatenate((x * x, 2 * x[:, [1, 0, 0]] * x[:, [2, 2, 1]], 2 * x), axis=1)


def _gradient_terms() -> Array:
    """L (9, 3, 4) of the linear gradient d xi_r / dx_k = sum_c L_rkc (x, y, z, 1)_c."""
    terms = np.zeros((9, 3, 4))
    for row, (i, j) in enumerate(((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))):
        terms[row, i, j] += 2.0
        if i != j:
            terms[row, j, i] += 2.0
    terms[[6, 7, 8], [0, 1, 2], 3] = 2.0
    return terms


_TERMS = _gradient_terms()
_NOISE_FROM_SECOND = np.einsum("rkc,skd->rscd", _TERMS, _TERMS).reshape(81, 16)
"""G G^T is quadratic in x: its mean follows from the second moments of (x, y, z, 1) alone."""


@njit(cache=True)
def weighted_sums(x: Array, theta: Array) -> tuple[Array, Array]:
    """Sums over points x (n, 3) of w xi xi^T (10, 10; upper triangle) and w u u^T (4, 4), in one pass.

    xi with its constant 1, u = (x, y, z, 1), w = 1 / |dQ/dx|^2 at theta.
    """
    fourth, second = np.zeros((10, 10)), np.zeros((4, 4))
    xi, u = np.ones(10), np.ones(4)
    a, b, c, f, g, h, p, q, r = theta[:9]
    for i in range(x.shape[0]):
        x0, x1, x2 = x[i, 0], x[i, 1], x[i, 2]
        s0, s1, s2 = a * x0 + h * x1 + g * x2 + p, h * x0 + b * x1 + f * x2 + q, g * x0 + f * x1 + c * x2 + r
        w = 0.25 / (s0 * s0 + s1 * s1 + s2 * s2)
        xi[0], xi[1], xi[2] = x0 * x0, x1 * x1, x2 * x2
        xi[3], xi[4], xi[5] = 2 * x1 * x2, 2 * x0 * x2, 2 * x0 * x1
        xi[6], xi[7], xi[8] = 2 * x0, 2 * x1, 2 * x2
        u[0], u[1], u[2] = x0, x1, x2
        for j in range(10):
            v = w * xi[j]
            for k in range(j, 10):
                fourth[j, k] += v * xi[k]
        for j in range(4):
            v = w * u[j]
            for k in range(4):
                second[j, k] += v * u[k]
    return fourth, second


def shape_matrix(theta: Array) -> Array:
    """The symmetric A (3, 3) of Q = x^T A x + 2 p^T x + d."""
    a, b, c, f, g, h = theta[:6]
    return np.array([[a, h, g], [h, b, f], [g, f, c]])


def fit_ellipsoid_specific(x: Array) -> Array:
    """Algebraic fit under 4 J - I^2 = 1, whose solution is always an ellipsoid: theta (10,).

    min |Q|^2 subject to v1^T C1 v1 = 1, v1 = theta[:6], I = a + b + c, J = ab + bc + ac - f^2 - g^2 - h^2.
    A sufficient condition: it cannot return an ellipsoid whose axes differ by much more than a factor of two.
    [LiGriffiths2004]
    """
    rows = np.concatenate((design(x), np.ones((len(x), 1))), axis=1)
    scatter = rows.T @ rows / len(x)
    s11, s12, s22 = scatter[:6, :6], scatter[:6, 6:], scatter[6:, 6:]
    linear = -np.linalg.solve(s22, s12.T)
    constraint = np.zeros((6, 6))
    constraint[:3, :3] = 1.0 - 2.0 * np.eye(3)
    constraint[3:, 3:] = -4.0 * np.eye(3)
    values, vectors = np.linalg.eig(np.linalg.solve(constraint, s11 + s12 @ linear))
    v1 = np.real(vectors[:, int(np.argmax(np.real(values)))])
    theta = np.concatenate((v1, linear @ v1))
    return np.asarray(theta * np.sign(np.trace(shape_matrix(theta))))


@dataclass(frozen=True)
class QuadricFit:
    """A fitted quadric: theta (10,), its covariance (10, 10), and the noise standard deviation of the points."""

    theta: Array
    covariance: Array
    noise_std: float


def refit(x: Array, theta: Array) -> QuadricFit:
    """One round of noise-adjusted, gradient-weighted least squares from a previous theta (10,).

    M u = lambda N u,  M = <w xi xi^T> (centred),  N = <w G G^T>,  G = d xi / dx,  w = 1 / |G^T theta|^2

    The smallest lambda is the noise variance and its vector the quadric: taking lambda N off M removes what noise alone
    adds to M, hence the bias of the plain algebraic fit; the weights make Q a distance (Sampson). Covariance by
    perturbation: sigma^2 / n sum_k lambda_k / (lambda_k - lambda_1)^2 u_k u_k^T. [Kanatani1994] (renormalisation).
    """
    fourth, second = weighted_sums(np.ascontiguousarray(x), theta)
    total = fourth[9, 9]
    fourth = fourth + np.triu(fourth, 1).T
    mean = fourth[:9, 9] / total
    moment = fourth[:9, :9] / total - np.outer(mean, mean)
    noise = (_NOISE_FROM_SECOND @ (second.ravel() / total)).reshape(9, 9)
    values, vectors = scipy.linalg.eigh(moment, noise)
    variance = max(float(values[0]) * len(x) / max(len(x) - 9, 1), ROUNDING_VARIANCE)
    gap = np.maximum(values[1:] - values[0], ROUNDING_VARIANCE)
    spread = (values[1:] + ROUNDING_VARIANCE) / gap**2 * variance / len(x)
    full = np.vstack((vectors, -mean @ vectors))
    full *= np.sign(np.trace(shape_matrix(full[:, 0])))
    return QuadricFit(full[:, 0], np.asarray((full[:, 1:] * spread) @ full[:, 1:].T), float(np.sqrt(variance)))


@dataclass(frozen=True)
class Ellipsoid:
    """(x - centre)^T T^-1 (x - centre) = 1 with T (3, 3) positive definite, and S = T^(1/2)."""

    centre: Array
    root: Array
    shape_inverse: Array
    level: float


def ellipsoid_of(theta: Array) -> Ellipsoid | None:
    """Centre and symmetric root of a quadric (10,), or None when it is no real ellipsoid.

    centre = -A^-1 p,  level = p^T A^-1 p - d,  T = level A^-1,  root = T^(1/2)
    """
    shape = shape_matrix(theta)
    values = np.linalg.eigvalsh(shape)
    if values[0] <= 1e-9 * values[-1]:
        return None
    inverse = np.linalg.inv(shape)
    centre = -inverse @ theta[6:9]
    level = float(-theta[6:9] @ centre - theta[9])
    if level <= 0:
        return None
    squares, axes = np.linalg.eigh(level * inverse)
    return Ellipsoid(centre, (axes * np.sqrt(squares)) @ axes.T, np.asarray(inverse), level)


def ellipsoid_jacobian(theta: Array, ellipsoid: Ellipsoid) -> Array:
    """d (centre, root's six: xx, xy, xz, yy, yz, zz) / d theta: (9, 10).

    d centre = -A^-1 (dp + dA centre);  dT = dlevel A^-1 - level A^-1 dA A^-1;  root droot + droot root = dT
    """
    upper = np.triu_indices(3)
    squares, axes = np.linalg.eigh(ellipsoid.level * ellipsoid.shape_inverse)
    sums = np.sqrt(squares)[:, None] + np.sqrt(squares)
    out = np.zeros((9, 10))
    for k, step in enumerate(np.eye(10)):
        d_shape, inverse, centre = shape_matrix(step), ellipsoid.shape_inverse, ellipsoid.centre
        d_level = -2 * step[6:9] @ centre - centre @ d_shape @ centre - step[9]
        d_square = d_level * inverse - ellipsoid.level * inverse @ d_shape @ inverse
        d_root = axes @ ((axes.T @ d_square @ axes) / sums) @ axes.T
        out[:3, k] = -inverse @ (step[6:9] + d_shape @ centre)
        out[3:, k] = d_root[upper]
    return out

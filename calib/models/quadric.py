"""Quadric surfaces in noisy points: design rows, their noise, and fits.

Q(x) = theta . xi(x) = a x^2 + b y^2 + c z^2 + 2 f yz + 2 g xz + 2 h xy + 2 p x + 2 q y + 2 r z + d,
theta = (a, b, c, f, g, h, p, q, r, d).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg.lapack import dgeev, dsygv

from scenarios.arrays import Array
from scenarios.kernel_cache import njit

ROUNDING_VARIANCE = 1e-18
"""Smallest noise variance of points of unit size: rounding, 1e-9 of their size."""


def design(x: Array) -> Array:
    """Rows xi(x) without the constant: (n, 9) for points (n, 3)."""
    rows = np.empty((len(x), 9))
    np.multiply(x, x, out=rows[:, :3])
    np.multiply(x, 2.0, out=rows[:, 6:])
    for column, (i, j) in enumerate(((1, 2), (0, 2), (0, 1)), start=3):
        np.multiply(rows[:, 6 + i], x[:, j], out=rows[:, column])
    return rows


def _noise_terms() -> Array:
    """K (81, 10) of G G^T = K xi (9, 9), G = d xi / dx (9, 3): quadratic in x, so its mean follows from xi's."""
    gradient = np.zeros((9, 3, 4))  # d xi_r / dx_k = sum_c gradient_rkc (x, y, z, 1)_c
    for row, (i, j) in enumerate(((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))):
        gradient[row, i, j] += 2.0
        if i != j:
            gradient[row, j, i] += 2.0
    gradient[[6, 7, 8], [0, 1, 2], 3] = 2.0
    place = np.array([[0, 5, 4, 6], [5, 1, 3, 7], [4, 3, 2, 8], [6, 7, 8, 9]])  # of the product cd in xi
    share = (1.0 + np.eye(4)) / 2  # xi holds the mixed products twice
    terms = np.einsum("rkc,skd,cd,cdm->rsm", gradient, gradient, share, np.eye(10)[place])
    return np.asarray(terms.reshape(81, 10))


_NOISE_TERMS = _noise_terms()
EVEN = np.array([0.0] * 6 + [0.5] + [0.0] * 3)
"""theta of a plane, whose gradient is 1 everywhere: every point weighs the same."""
BLOCK = 64
"""Points summed together: few enough to stay in the first cache, many enough for the vector units."""


@njit(cache=True, fastmath={"reassoc", "contract"})
def weighted_scatter(x: Array, theta: Array) -> Array:
    """Sum over points x (n, 3) of w xi xi^T (10, 10), xi with its constant 1, in one pass.

    w = 1 / |dQ/dx|^2 at theta (10,)
    """
    scatter = np.zeros((10, 10))
    rows, weighted = np.ones((10, BLOCK)), np.empty((10, BLOCK))
    a, b, c, f, g, h, p, q, r = theta[:9]
    for first in range(0, len(x), BLOCK):
        n = min(BLOCK, len(x) - first)
        for i in range(n):
            x0, x1, x2 = x[first + i, 0], x[first + i, 1], x[first + i, 2]
            s0, s1, s2 = a * x0 + h * x1 + g * x2 + p, h * x0 + b * x1 + f * x2 + q, g * x0 + f * x1 + c * x2 + r
            weighted[9, i] = 0.25 / (s0 * s0 + s1 * s1 + s2 * s2)
            rows[0, i], rows[1, i], rows[2, i] = x0 * x0, x1 * x1, x2 * x2
            rows[3, i], rows[4, i], rows[5, i] = 2 * x1 * x2, 2 * x0 * x2, 2 * x0 * x1
            rows[6, i], rows[7, i], rows[8, i] = 2 * x0, 2 * x1, 2 * x2
        for j in range(10):
            for i in range(n):
                weighted[j, i] = weighted[9, i] * rows[j, i]
            for k in range(j, 10):
                total = 0.0
                for i in range(n):
                    total += weighted[j, i] * rows[k, i]
                scatter[j, k] += total
    for j in range(10):
        for k in range(j):
            scatter[j, k] = scatter[k, j]
    return scatter


def shape_matrix(theta: Array) -> Array:
    """The symmetric A (3, 3) of Q = x^T A x + 2 p^T x + d."""
    a, b, c, f, g, h = theta[:6]
    return np.array([[a, h, g], [h, b, f], [g, f, c]])


_CONSTRAINT_INVERSE = np.linalg.inv(
    np.block([[1.0 - 2.0 * np.eye(3), np.zeros((3, 3))], [np.zeros((3, 3)), -4.0 * np.eye(3)]])
)
"""C1^-1 of 4 J - I^2 = v1^T C1 v1."""


def fit_ellipsoid_specific(x: Array) -> Array:
    """Algebraic fit under 4 J - I^2 = 1, whose solution is always an ellipsoid: theta (10,).

    min |Q|^2 subject to v1^T C1 v1 = 1, v1 = theta[:6], I = a + b + c, J = ab + bc + ac - f^2 - g^2 - h^2.
    A sufficient condition: it cannot return an ellipsoid whose axes differ by much more than a factor of two.
    [LiGriffiths2004]
    """
    scatter = weighted_scatter(x, EVEN) / len(x)
    s11, s12, s22 = scatter[:6, :6], scatter[:6, 6:], scatter[6:, 6:]
    linear = -np.linalg.solve(s22, s12.T)
    values, _, _, vectors, info = dgeev(_CONSTRAINT_INVERSE @ (s11 + s12 @ linear), compute_vl=0)
    if info:
        raise np.linalg.LinAlgError("the points do not determine a quadric")
    v1 = vectors[:, int(np.argmax(values))]
    return np.asarray(np.concatenate((v1, linear @ v1)) * np.sign(v1[:3].sum()))


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
    scatter = weighted_scatter(x, theta)
    scatter = scatter / scatter[9, 9]
    mean = scatter[:9, 9]
    values, vectors, info = dsygv(scatter[:9, :9] - np.outer(mean, mean), (_NOISE_TERMS @ scatter[9]).reshape(9, 9))
    if info:
        raise np.linalg.LinAlgError("the points do not determine a quadric")
    variance = max(float(values[0]) * len(x) / max(len(x) - 9, 1), ROUNDING_VARIANCE)
    gap = np.maximum(values[1:] - values[0], ROUNDING_VARIANCE)
    spread = (values[1:] + ROUNDING_VARIANCE) / gap**2 * variance / len(x)
    full = np.concatenate((vectors, -mean[None] @ vectors))
    theta = full[:, 0] * np.sign(full[:3, 0].sum())
    return QuadricFit(theta, np.asarray((full[:, 1:] * spread) @ full[:, 1:].T), float(np.sqrt(variance)))

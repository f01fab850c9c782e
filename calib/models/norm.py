"""The norm residual |T x - c| - 1 with its exact gradient and Hessian, and what follows from its nine parameters.

x (n, 3) are standardised measurements, x = (m - middle) / scale, and T is symmetric:
p = (T_xx, T_xy, T_xz, T_yy, T_yz, T_zz, c_x, c_y, c_z). y = T x - c is linear in p, and |y| = 1 where |h| = F.
Back in nT: b = middle + scale T^-1 c and S = scale / F T^-1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from calib.models.quadric import UPPER
from calib.numerics.moments import mean_and_spread
from calib.reference import Reference
from calib.result import OFFSET_NAMES, Calibration, Status

Array = NDArray[np.float64]
SYMMETRIC_NAMES = ("S_xx", "S_xy", "S_xz", "S_yy", "S_yz", "S_zz")


@dataclass(frozen=True)
class Standardised:
    """Measurements moved to their mean and divided by their rms distance from it: x (n, 3)."""

    x: Array
    middle_nT: Array
    scale_nT: float

    @classmethod
    def of(cls, mag_nT: Array) -> Standardised:
        """Standardise measurements (n, 3)."""
        x = np.ascontiguousarray(mag_nT)
        middle, spread = mean_and_spread(x)
        scale = float(np.sqrt(spread.trace() * (len(x) - 1) / len(x)))
        return cls(_moved(x, middle, scale), middle, scale)

    def calibration(self, name: str, status: Status, fit: NormFit, reference: Reference) -> Calibration:
        """The fit in nT: offset b, symmetric S, their covariance, and the noise of a measured component."""
        gain = self.scale_nT / reference.strength_nT
        offset_nT = self.middle_nT + self.scale_nT * fit.centre
        names = (*OFFSET_NAMES, *SYMMETRIC_NAMES)
        values = np.concatenate((offset_nT, gain * fit.root[UPPER]))
        units = np.array([self.scale_nT] * 3 + [gain] * 6)
        parameters = dict(zip(names, values.tolist(), strict=True)) | {"noise_std_nT": fit.noise_std * self.scale_nT}
        return Calibration(
            name=name,
            status=status,
            offset_nT=offset_nT,
            matrix=np.asarray(np.linalg.inv(gain * fit.root)),
            parameters=parameters,
            covariance=fit.covariance * np.outer(units, units),
            covariance_names=names,
            history=fit.history,
        )


@njit(cache=True)
def _moved(x: Array, middle: Array, scale: float) -> Array:
    """(x - middle) / scale (n, 3)."""
    out = np.empty((len(x), 3))
    for i in range(len(x)):
        for j in range(3):
            out[i, j] = (x[i, j] - middle[j]) / scale
    return out


@dataclass(frozen=True)
class NormFit:
    """An ellipsoid x = root h + centre, |h| = 1, in standardised units.

    covariance (9, 9): mean square error of (centre, root's six: xx, xy, xz, yy, yz, zz); noise_std of a component of x.
    """

    centre: Array
    root: Array
    covariance: Array
    noise_std: float
    history: tuple[float, ...]


def symmetric(six: Array) -> Array:
    """The symmetric (3, 3) of its upper triangle, row by row (6,)."""
    xx, xy, xz, yy, yz, zz = six
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def parameters_of(T: Array, c: Array) -> Array:
    """p (9,) of T (3, 3) and c (3,)."""
    return np.concatenate((T[UPPER], c))


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


def _slots() -> Array:
    """y_i = sum_p,k SLOTS[i, p, k] p_p (x, 1)_k."""
    out = np.zeros((3, 9, 4))
    for p, (i, j) in enumerate(zip(*UPPER, strict=True)):
        out[i, p, j] = out[j, p, i] = 1.0
    out[[0, 1, 2], [6, 7, 8], 3] = -1.0
    return out


SLOTS = _slots()


def norm_fit(p: Array, x: Array, history: tuple[float, ...]) -> NormFit:
    """Centre and root of p, and their mean square error by noise of equal strength on the components of x.

    covariance of p = H^-1 (sigma^2 sum |T u|^2 q q^T) H^-1 + delta delta^T,  H = half the Hessian,
    delta = -H^-1 sum E[r q],  sigma^2 = sum r^2 / (mean |T u|^2 (n - 9))

    delta is the bias of second order in the noise: the cost falls when T shrinks the noise with the points, which a
    motion that excites an axis weakly does not prevent.
    """
    T, c = symmetric(p[:6]), p[6:]
    f, _, hessian = norm_derivatives(p, x)
    steep, outer, expected = noise_sums(p, x)
    inverse = np.linalg.inv(hessian / 2)
    variance = f / (steep / len(x) * max(len(x) - 9, 1))
    meat = np.triu(outer) + np.triu(outer, 1).T
    bias = inverse @ expected * variance
    jacobian = _physical_jacobian(T, c)
    covariance = jacobian @ (variance * inverse @ meat @ inverse + np.outer(bias, bias)) @ jacobian.T
    root = np.asarray(np.linalg.inv(T), dtype=np.float64)
    return NormFit(root @ c, root, covariance, float(np.sqrt(variance)), history)


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


def _physical_jacobian(T: Array, c: Array) -> Array:
    """d (centre, root's six) / dp (9, 9): centre = T^-1 c, root = T^-1."""
    root = np.linalg.inv(T)
    d_T, d_c = SLOTS[:, :, :3].transpose(1, 0, 2), -SLOTS[:, :, 3].T
    d_root = -root @ d_T @ root
    return np.concatenate(((d_c - d_T @ (root @ c)) @ root, d_root[:, *UPPER]), axis=1).T

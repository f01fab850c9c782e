"""Ellipsoid: centre and symmetric root, the coordinates of the fits, and the covariance.

x = root h + centre, |h| = 1.  Fits use either of two sets of coordinates; the covariance follows by
d (centre, root) / d (coordinates):

norm     p = (T_xx, T_xy, T_xz, T_yy, T_yz, T_zz, c_x, c_y, c_z) of |T x - c| = 1: root = T^-1, centre = T^-1 c
quadric  theta = (a, b, c, f, g, h, p, q, r, d) of x^T A x + 2 p^T x + d = 0, see `calib.models.quadric`
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from calib.models.quadric import shape_matrix
from calib.numerics.points import mean_and_spread, scaled
from calib.reference import Reference
from calib.result import OFFSET_NAMES, Calibration, Status
from scenarios.arrays import Array

SYMMETRIC_NAMES = ("S_xx", "S_xy", "S_xz", "S_yy", "S_yz", "S_zz")
UPPER = np.triu_indices(3)
DEFINITE = 1e-5
"""A shape whose smallest eigenvalue is a smaller part of the largest, axes more than 316 to 1, is two planes that noise
has bent, not an ellipsoid."""
SHAPE_STEPS = np.array([shape_matrix(step) for step in np.eye(10)])
LINEAR_STEPS, CONSTANT_STEP = np.eye(10)[:, 6:9], np.eye(10)[:, 9]
"""d (A, p, d) / d theta."""


@dataclass(frozen=True, eq=False)
class Ellipsoid:
    """Centre (3,) and symmetric, positive definite root (3, 3)."""

    centre: Array
    root: Array

    @classmethod
    def of_norm(cls, p: Array) -> Ellipsoid:
        """From norm coordinates (9,)."""
        root = np.asarray(np.linalg.inv(symmetric(p[:6])), dtype=np.float64)
        return cls(root @ p[6:], root)

    @classmethod
    def of_quadric(cls, theta: Array) -> Ellipsoid | None:
        """From quadric coordinates (10,), or None when it is no real ellipsoid."""
        form = CentralForm.of(theta)
        return None if form is None else form.ellipsoid

    @property
    def norm(self) -> Array:
        """Norm coordinates p (9,)."""
        T = np.asarray(np.linalg.inv(self.root), dtype=np.float64)
        return norm_coordinates(T, T @ self.centre)


@dataclass(frozen=True, eq=False)
class CentralForm:
    """An ellipsoid in central form: centre, principal axes V (3, 3) in columns, curvatures k (3,).

    (x - centre)^T A (x - centre) = level,  A = V diag(k) V^T
    """

    centre: Array
    level: float
    curvatures: Array
    axes: Array

    @classmethod
    def of(cls, theta: Array) -> CentralForm | None:
        """From quadric coordinates (10,), or None when it is no real ellipsoid.

        centre = -A^-1 p,  level = p^T A^-1 p - d
        """
        curvatures, axes = np.linalg.eigh(shape_matrix(theta))
        if not curvatures[0] > DEFINITE * curvatures[-1]:
            return None
        centre = -axes @ (axes.T @ theta[6:9] / curvatures)
        level = float(-theta[6:9] @ centre - theta[9])
        return cls(centre, level, curvatures, axes) if level > 0 else None

    @property
    def ellipsoid(self) -> Ellipsoid:
        """root = (level A^-1)^(1/2)."""
        return Ellipsoid(self.centre, (self.axes * np.sqrt(self.level / self.curvatures)) @ self.axes.T)

    @property
    def jacobian(self) -> Array:
        """d (centre, root's six) / d theta (9, 10).

        d centre = -A^-1 (dp + dA centre);  root droot + droot root = dW,  dW = dlevel A^-1 - level A^-1 dA A^-1, which
        along the axes is V^T droot V = V^T dW V / (r_i + r_j), r the semi-axes
        """
        k, V = self.curvatures, self.axes
        turned = SHAPE_STEPS @ self.centre
        d_level = -2 * LINEAR_STEPS @ self.centre - turned @ self.centre - CONSTANT_STEP
        d_shape = V.T @ SHAPE_STEPS @ V
        d_square = d_level[:, None, None] * np.diag(1 / k) - self.level * d_shape / np.outer(k, k)
        semi_axes = np.sqrt(self.level / k)
        d_root = V @ (d_square / (semi_axes[:, None] + semi_axes)) @ V.T
        d_centre = -(V / k) @ V.T @ (LINEAR_STEPS + turned).T
        return np.concatenate((d_centre, d_root[:, *UPPER].T))


@dataclass(frozen=True, eq=False)
class EllipsoidFit:
    """An ellipsoid, the mean square error (9, 9) of its centre and root's six, and the noise of a component of x."""

    ellipsoid: Ellipsoid
    covariance: Array
    noise_std: float
    history: tuple[float, ...] = ()

    @classmethod
    def of_norm(cls, p: Array, error: Array, noise_std: float, history: tuple[float, ...] = ()) -> EllipsoidFit:
        """From norm coordinates (9,) and their mean square error (9, 9)."""
        jacobian = norm_jacobian(p)
        return cls(Ellipsoid.of_norm(p), jacobian @ error @ jacobian.T, noise_std, history)

    @classmethod
    def of_quadric(
        cls, theta: Array, error: Array, noise_std: float, history: tuple[float, ...] = ()
    ) -> EllipsoidFit | None:
        """From quadric coordinates (10,) and their mean square error (10, 10); None when it is no real ellipsoid."""
        form = CentralForm.of(theta)
        if form is None:
            return None
        jacobian = form.jacobian
        return cls(form.ellipsoid, jacobian @ error @ jacobian.T, noise_std, history)


def mean_square_error(
    information: Array, variance: float, meat: Array | None = None, bias: Array | None = None
) -> Array:
    """Error (k, k) of the minimum of a sum of squares with noise of that variance in its points.

    H^-1 M H^-1 variance + delta delta^T,  delta = H^-1 bias variance

    information H: Gauss-Newton's matrix; meat M: covariance of the gradient, H where None; bias: mean gradient of
    second order in the noise, for noise of variance one.
    """
    inverse = np.linalg.inv(information)
    spread = variance * inverse if meat is None else variance * inverse @ meat @ inverse
    spread = (spread + spread.T) / 2
    if bias is None:
        return np.asarray(spread)
    delta = variance * inverse @ bias
    return np.asarray(spread + np.outer(delta, delta))


def norm_jacobian(p: Array) -> Array:
    """d (centre, root's six) / d p (9, 9)."""
    T, c = symmetric(p[:6]), p[6:]
    root = np.linalg.inv(T)
    d_T, d_c = SLOTS[:, :, :3].transpose(1, 0, 2), -SLOTS[:, :, 3].T
    d_root = -root @ d_T @ root
    return np.concatenate(((d_c - d_T @ (root @ c)) @ root, d_root[:, *UPPER]), axis=1).T


def is_definite(shape: Array) -> bool:
    """Whether a symmetric (3, 3) is positive definite, see DEFINITE."""
    values = np.linalg.eigvalsh(shape)
    return bool(values[0] > DEFINITE * values[-1])


def symmetric(six: Array) -> Array:
    """The symmetric (3, 3) of its upper triangle, row by row (6,)."""
    xx, xy, xz, yy, yz, zz = six
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def symmetric_root(square: Array) -> Array:
    """The symmetric root (3, 3) of a positive semi-definite matrix."""
    values, axes = np.linalg.eigh(square)
    return np.asarray((axes * np.sqrt(np.maximum(values, 0.0))) @ axes.T)


def norm_coordinates(T: Array, c: Array) -> Array:
    """p (9,) of T (3, 3) and c (3,)."""
    return np.concatenate((T[UPPER], c))


def _slots() -> Array:
    """(T x - c)_i = sum_p,k SLOTS[i, p, k] p_p (x, 1)_k."""
    out = np.zeros((3, 9, 4))
    for p, (i, j) in enumerate(zip(*UPPER, strict=True)):
        out[i, p, j] = out[j, p, i] = 1.0
    out[[0, 1, 2], [6, 7, 8], 3] = -1.0
    return out


SLOTS = _slots()
FULL_SLOTS, SYMMETRIC_SLOTS = np.eye(9).reshape(9, 3, 3), np.ascontiguousarray(SLOTS[:, :6, :3].transpose(1, 0, 2))
"""d matrix / d its entries: of all nine, and of the upper triangle of a symmetric one."""


@dataclass(frozen=True, eq=False)
class Standardised:
    """Measurements in a unit of their own: x (n, 3) = (m - middle) / scale."""

    x: Array
    middle_nT: Array
    scale_nT: float

    @classmethod
    def of(cls, mag_nT: Array) -> Standardised:
        """Measurements (n, 3) moved to their mean and divided by their rms distance from it."""
        x = np.ascontiguousarray(mag_nT)
        middle, spread = mean_and_spread(x)
        scale = float(np.sqrt(spread.trace() * (len(x) - 1) / len(x)))
        return cls(scaled(x, middle, scale), middle, scale)

    def calibration(self, name: str, status: Status, fit: EllipsoidFit, reference: Reference) -> Calibration:
        """The fit in nT: b = middle + scale centre, S = scale / F root, and the noise of a measured component."""
        gain = self.scale_nT / reference.strength_nT
        offset_nT = self.middle_nT + self.scale_nT * fit.ellipsoid.centre
        names = (*OFFSET_NAMES, *SYMMETRIC_NAMES)
        values = np.concatenate((offset_nT, gain * fit.ellipsoid.root[UPPER]))
        units = np.array([self.scale_nT] * 3 + [gain] * 6)
        parameters = dict(zip(names, values.tolist(), strict=True)) | {"noise_std_nT": fit.noise_std * self.scale_nT}
        return Calibration(
            name=name,
            status=status,
            offset_nT=offset_nT,
            matrix=np.asarray(np.linalg.inv(gain * fit.ellipsoid.root)),
            parameters=parameters,
            covariance=fit.covariance * np.outer(units, units),
            covariance_names=names,
            history=fit.history,
        )

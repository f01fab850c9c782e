"""Response of a fit to the noise of a sample, to first order: K (n, p, 3), parameters = truth + sum_i K_i n_i."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calib.models.ellipsoid import SYMMETRIC_NAMES
from calib.numerics.points import lengths_and_slopes
from calib.result import OFFSET_NAMES, Calibration
from scenarios.arrays import Array
from scenarios.kernel_cache import njit


@dataclass(frozen=True, eq=False)
class Response:
    """K (n, p, 3) of the parameters named, in the order of the samples."""

    K: Array
    names: tuple[str, ...]

    def without(self, absent: NDArray[np.intp]) -> Response:
        """The response without the samples of some indices."""
        return Response(np.delete(self.K, absent, axis=0), self.names) if len(absent) else self


def strength_rows(fit: Calibration, field_nT: Array, strength_nT: float) -> tuple[Array, Array]:
    """What a fit leaves of the strength, r = |h| - F (n,), and how noise enters it: r = a . n, a = S^-T u (n, 3)."""
    size, slope = lengths_and_slopes(np.ascontiguousarray(field_nT), np.ascontiguousarray(fit.matrix))
    return size - strength_nT, slope


def of_strength(fit: Calibration, field_nT: Array, strength_nT: float) -> Response:
    """Of offset and symmetric S, or offset and scale, from the strength: least squares of the distances a . n / |a|.

    K_i = (sum w J J^T)^-1 w_i J_i a_i^T,  w = 1 / |a|^2
    field_nT h (n, 3): the corrected field, in whichever frame.
    """
    a, J, names = strength_columns(fit, field_nT, strength_nT)
    weighted = J / np.einsum("ni,ni->n", a, a)[:, None]
    found = weighted @ np.linalg.pinv(J.T @ weighted, hermitian=True)
    found[:, 3:] /= strength_nT
    return Response(found[:, :, None] * a[:, None, :], names)


def strength_columns(fit: Calibration, field_nT: Array, strength_nT: float) -> tuple[Array, Array, tuple[str, ...]]:
    """a (n, 3), and d |h| / d p (n, k) up to sign with the names of p, S's parameters times the strength.

    J = a of b, a h^T + h a^T of S's six, a . h of a scale
    """
    _, a = strength_rows(fit, field_nT, strength_nT)
    left, _, right = np.linalg.svd(fit.matrix)
    h = field_nT @ left @ right / strength_nT
    if "scale" in fit.covariance_names:
        return a, np.column_stack((a, np.einsum("ni,ni->n", a, h))), (*OFFSET_NAMES, "scale")
    return a, _symmetric_columns(a, h), (*OFFSET_NAMES, *SYMMETRIC_NAMES)


@njit(cache=True)
def _symmetric_columns(a: Array, h: Array) -> Array:
    """a and the upper triangle of ``a h^T + h a^T``, the diagonal halved (n, 9)."""
    out = np.empty((len(a), 9))
    for n in range(len(a)):
        at = 3
        for i in range(3):
            out[n, i] = a[n, i]
            for j in range(i, 3):
                out[n, at] = a[n, i] * h[n, j] if i == j else a[n, i] * h[n, j] + a[n, j] * h[n, i]
                at += 1
    return out


def of_vector(field_nT: Array) -> Response:
    """Of the offset, with the field h (n, 3) known in the body frame: K_i = (sum x x^T)^-1 x_i, x = (1, h), an axis."""
    x = np.column_stack((np.ones(len(field_nT)), field_nT / np.abs(field_nT).max()))
    found = x @ np.linalg.pinv(x.T @ x, hermitian=True)[:, 0]
    return Response(found[:, None, None] * np.eye(3), OFFSET_NAMES)

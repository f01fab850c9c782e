"""Separate corrections of non-orthogonality and non-levelness, the rivals of [Zhou2012]'s joint correction."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.optimize import least_squares

from calib.models.turntable import axes_matrix
from scenarios.arrays import Array

Axes = Callable[[Array], Array]
ALONE = ("non-orthogonality alone", "non-levelness alone")
"""Corrections of one error as if the other were absent."""


def skewed(theta: Array) -> Array:
    """Return T (3, 3) of level sensor axes, z vertical, with theta = (a1, b1, b2): c1 = c2 = 0."""
    return axes_matrix(np.array([*theta, 0.0, 0.0]))


def tilted(theta: Array) -> Array:
    """Return the rotation R (3, 3) of orthogonal axes, rows x, y, z; z holds theta = (c1, c2), x lies over level x."""
    z = np.array([*theta, np.sqrt(1.0 - theta @ theta)])
    x = np.array([z[2], 0.0, -z[0]]) / np.hypot(z[2], z[0])
    return np.array([x, np.cross(z, x), z])


def corrections(mag_nT: Array) -> dict[str, Array]:
    """Return the corrected field (n, 3), nT, of a turn's measurements (n, 3), by the way of correction.

    m = T R h: T from a constant length of T^-1 m, R from a constant z of R^-1 m. Alone, or "both, separately", each is
    found on m as if the other were absent; "one after the other" finds R on T^-1 m. Azimuth is counted from the
    vertical plane of x, as in the paper.
    """
    T, R = _found(skewed, 3, mag_nT, _length), _found(tilted, 2, mag_nT, _vertical)
    after = _found(tilted, 2, mag_nT @ np.linalg.inv(T).T, _vertical)
    found = {
        **dict(zip(ALONE, (T, R), strict=True)),
        "both, separately": T @ R,
        "one after the other": T @ after,
    }
    return {name: mag_nT @ np.linalg.inv(turned(A)).T for name, A in found.items()}


def turned(A: Array) -> Array:
    """Return the axes A (3, 3) turned about the vertical until x has no part along level y."""
    cosine, sine = A[0, :2] / np.hypot(*A[0, :2])
    return np.asarray(A @ np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]]))


def _length(h: Array) -> Array:
    return np.asarray(np.linalg.norm(h, axis=1))


def _vertical(h: Array) -> Array:
    return h[:, 2]


def _found(axes: Axes, size: int, mag_nT: Array, constant: Callable[[Array], Array]) -> Array:
    """Return the axes (3, 3) under which `constant` of the corrected field varies least over the turn."""

    def deviation(theta: Array) -> Array:
        values = constant(mag_nT @ np.linalg.inv(axes(theta)).T)
        return np.asarray(values - values.mean())

    return np.asarray(axes(least_squares(deviation, np.zeros(size), xtol=1e-14, ftol=1e-14, gtol=1e-14).x))

"""The level turn: an ellipse in the sensor's x and y.

p = S h + b,  |h| = H,  u = T (p - b),  T = S^-1 / H symmetric:  |u| = 1

p, h, b (2,) : the x and y components; H horizontal strength of the field. The constant vertical field adds to b.
Coordinates of the fit: theta = (b_x, b_y, T_xx, T_xy, T_yy).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from scenarios.arrays import Array

ROOT_SLOTS = np.array([[[1.0, 0.0], [0.0, 0.0]], [[0.0, 1.0], [1.0, 0.0]], [[0.0, 0.0], [0.0, 1.0]]])
"""dT / d (T_xx, T_xy, T_yy), (3, 2, 2)."""
PARAMETERS = 5


@dataclass(frozen=True, eq=False)
class Ellipse:
    """Centre (2,) and symmetric root (2, 2) of the ellipse centre + root u, |u| = 1; both in nT.

    covariance (5, 5) : of the centre and of root's xx, xy, yy; distance_nT (n,) : signed distances of the points.
    """

    centre: Array
    root: Array
    covariance: Array
    distance_nT: Array
    settled: bool

    @property
    def radius_nT(self) -> float:
        """Radius of the circle of equal area."""
        return float(np.sqrt(np.linalg.det(self.root)))

    @property
    def noise_nT(self) -> float:
        """Standard deviation of a point's distance."""
        return float(np.sqrt(self.distance_nT @ self.distance_nT / (len(self.distance_nT) - PARAMETERS)))

    @classmethod
    def of(cls, points: Array) -> Ellipse | None:
        """Least squares of the distances of points (n, 2) to the ellipse; None where no ellipse fits.

        min over theta of sum (|u_i| - 1)^2 / |T u_i / |u_i||^2, the distances to first order [Ahn2002]
        """
        middle, scale = points.mean(axis=0), float(np.sqrt(points.var(axis=0).sum()))
        x = (points - middle) / scale
        start = _algebraic(x)
        if start is None:
            return None
        found = least_squares(_distances, start, _slopes, args=(x,), method="lm", x_scale="jac")
        T = _symmetric(found.x[2:])
        if not np.linalg.eigvalsh(T)[0] > 0:
            return None
        variance = float(found.fun @ found.fun) / (len(x) - PARAMETERS)
        root = np.asarray(np.linalg.inv(T))
        to_root = -(root @ ROOT_SLOTS @ root)[:, [0, 0, 1], [0, 1, 1]].T
        jacobian = scale * np.block([[np.eye(2), np.zeros((2, 3))], [np.zeros((3, 2)), to_root]])
        covariance = variance * jacobian @ np.linalg.inv(found.jac.T @ found.jac) @ jacobian.T
        return cls(middle + scale * found.x[:2], scale * root, covariance, scale * found.fun, bool(found.success))


def _symmetric(three: Array) -> Array:
    return np.array([[three[0], three[1]], [three[1], three[2]]])


def _distances(theta: Array, x: Array) -> Array:
    """(|u| - 1) / |T u / |u|| (n,)."""
    T = _symmetric(theta[2:])
    u = (x - theta[:2]) @ T
    size = np.linalg.norm(u, axis=1)
    return np.asarray((size - 1.0) / np.linalg.norm(u / size[:, None] @ T, axis=1))


def _slopes(theta: Array, x: Array) -> Array:
    """Derivatives (n, 5) of the distances at a constant denominator, which adds terms of the order of the noise only.

    d |u| = e . (dT (x - b) - T db),  e = u / |u|
    """
    T = _symmetric(theta[2:])
    off = x - theta[:2]
    u = off @ T
    e = u / np.linalg.norm(u, axis=1)[:, None]
    steep = e @ T
    columns = np.concatenate((-steep, np.einsum("ni,pij,nj->np", e, ROOT_SLOTS, off)), axis=1)
    return np.asarray(columns / np.linalg.norm(steep, axis=1)[:, None])


def _algebraic(x: Array) -> Array | None:
    """Start theta (5,) from the conic a x^2 + 2 b x y + c y^2 + 2 d x + 2 e y = f, with a + c = 2; None for no ellipse.

    Written as a circle and what differs: (x^2 + y^2) + a' (x^2 - y^2) + ..., linear least squares.
    """
    px, py = x.T
    design = np.column_stack((px**2 - py**2, 2 * px * py, 2 * px, 2 * py, -np.ones(len(x))))
    found = np.linalg.lstsq(design, -(px**2 + py**2), rcond=None)[0]
    shape = np.array([[1.0 + found[0], found[1]], [found[1], 1.0 - found[0]]])
    values, axes = np.linalg.eigh(shape)
    if not values[0] > 0:
        return None
    centre = -np.linalg.solve(shape, found[2:4])
    level = float(found[4] + centre @ shape @ centre)
    T = (axes * np.sqrt(values / level)) @ axes.T
    return np.array([*centre, T[0, 0], T[0, 1], T[1, 1]])

"""Distance of points from an ellipsoid, and derivatives with respect to the ellipsoid.

x = G u + c + n, |u| = 1, G symmetric, n white: the most likely direction u of a point is the direction of the nearest
point of the ellipsoid, and the residual is the distance. q = (c, G_xx, G_xy, G_xz, G_yy, G_yz, G_zz) (9,).
"""

from __future__ import annotations

import numpy as np

from scenarios.arrays import Array
from scenarios.kernel_cache import njit

FOOT_STEPS = 60
"""Newton steps to the nearest point: some four near the surface, more for a start that is far off."""
FOOT_TOLERANCE = 1e-14
"""Of |u|^2 - 1 at the nearest point."""

TINY = 1e-300
"""Keeps a point on the plane across the shortest axis, too near the centre to have one nearest point, from 0 / 0: one
of its two nearest is taken."""


@njit(cache=True)
def _multiplier(y: Array, a: Array) -> float:
    """t of the nearest point a_k^2 y_k / (a_k^2 + t) to y (3,) on the ellipsoid of semi-axes a (3,), positive outside.

    The largest root of f(t) = sum (a_k y_k / (a_k^2 + t))^2 - 1, convex and falling beyond -min a^2: Newton's steps
    rise to it from wherever f > 0.
    """
    least = -np.inf
    for k in range(3):
        least = max(least, -(a[k] ** 2) + a[k] * abs(y[k]))
    t = max(least, 0.0)
    for _ in range(FOOT_STEPS):
        f, slope = -1.0, 0.0
        for k in range(3):
            down = a[k] ** 2 + t
            if down > 0.0:
                part = (a[k] * y[k] / down) ** 2
                f, slope = f + part, slope - 2.0 * part / down
        new = max(t - f / slope, least) if slope < 0.0 else least
        if abs(f) < FOOT_TOLERANCE or new == t:
            break
        t = new
    return t


@njit(cache=True)
def _square(v: Array) -> float:
    """|v|^2 of a vector (3,), without the array that v**2 is."""
    return float(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])


@njit(cache=True)
def distances(x: Array, centre: Array, semi: Array, axes: Array) -> tuple[Array, Array, Array, Array]:
    """Distance (n,) of points x (n, 3), positive outside; direction u and normal (n, 3) there; mean curvature (n,).

    G = axes diag(semi) axes^T. With y along the axes, u_k = a_k y_k / (a_k^2 + t), g = (u_k / a_k), normal = g / |g|,
    distance = t |g|, curvature = (|g|^2 sum 1 / a_k^2 - sum (g_k / a_k)^2) / (2 |g|^3).
    """
    n = len(x)
    distance, curvature = np.empty(n), np.empty(n)
    direction, normal = np.empty((n, 3)), np.empty((n, 3))
    y, u, g = np.empty(3), np.empty(3), np.empty(3)
    whole, least = (1.0 / semi**2).sum(), int(np.argmin(semi))
    for i in range(n):
        for k in range(3):
            y[k] = 0.0
            for j in range(3):
                y[k] += axes[j, k] * (x[i, j] - centre[j])
        t = _multiplier(y, semi)
        for k in range(3):
            u[k] = semi[k] * y[k] / max(semi[k] ** 2 + t, TINY)
        if t <= -(semi[least] ** 2):
            u[least] = np.sqrt(max(1.0 - _square(u), 0.0))
        unit = np.sqrt(_square(u))
        bent = 0.0
        for k in range(3):
            u[k] /= unit
            g[k] = u[k] / semi[k]
            bent += (g[k] / semi[k]) ** 2
        size = np.sqrt(_square(g))
        distance[i] = t * size
        curvature[i] = (size**2 * whole - bent) / (2.0 * size**3)
        for j in range(3):
            direction[i, j] = axes[j, 0] * u[0] + axes[j, 1] * u[1] + axes[j, 2] * u[2]
            normal[i, j] = (axes[j, 0] * g[0] + axes[j, 1] * g[1] + axes[j, 2] * g[2]) / size
    return distance, direction, normal, curvature


@njit(cache=True)
def slopes(direction: Array, normal: Array) -> Array:
    """d distance / d q (n, 9) = -normal . d (G u + c) / d q: the nearest point slides along the surface only."""
    out = np.empty((len(direction), 9))
    for i in range(len(direction)):
        u, v = direction[i], normal[i]
        for k in range(3):
            out[i, k] = -v[k]
        out[i, 3], out[i, 6], out[i, 8] = -v[0] * u[0], -v[1] * u[1], -v[2] * u[2]
        out[i, 4] = -v[0] * u[1] - v[1] * u[0]
        out[i, 5] = -v[0] * u[2] - v[2] * u[0]
        out[i, 7] = -v[1] * u[2] - v[2] * u[1]
    return out

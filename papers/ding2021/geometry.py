"""The five arrangements of sensors that [Ding2021] names, and the gradient tensor of each by least squares.

B_i = B_0 + G r_i,  G symmetric and trace-free: five components and the mean field from three or four sensors at r_i,
counted from their centre. On the cross these are the paper's differences (eq. 1), with the two estimates of Bxy
averaged.
"""

from __future__ import annotations

import numpy as np

from scenarios.arrays import Array

CROSS = "cross"
CORNER = 8**-0.5
"""Half the side of the cube in whose corners a regular tetrahedron of edge 1 stands."""
ARRANGEMENTS: dict[str, tuple[tuple[float, float, float], ...]] = {
    CROSS: ((0.5, 0.0, 0.0), (0.0, 0.5, 0.0), (-0.5, 0.0, 0.0), (0.0, -0.5, 0.0)),
    "square": ((0.5, 0.5, 0.0), (-0.5, 0.5, 0.0), (-0.5, -0.5, 0.0), (0.5, -0.5, 0.0)),
    "triangle": ((0.5, 0.0, 0.0), (-0.5, 0.0, 0.0), (0.0, 3**0.5 / 2, 0.0)),
    "right-angled tetrahedron": ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    "regular tetrahedron": (
        (CORNER,) * 3,
        (CORNER, -CORNER, -CORNER),
        (-CORNER, CORNER, -CORNER),
        (-CORNER, -CORNER, CORNER),
    ),
}
"""Places of the sensors, baseline 1: opposite sensors of the cross, sides, legs at the right angle, edges."""


def places(name: str) -> Array:
    """Return the places (k, 3) of an arrangement with baseline 1, about their centre."""
    place = np.array(ARRANGEMENTS[name])
    return np.asarray(place - place.mean(axis=0))


def reach(name: str) -> float:
    """Return the distance of the farthest sensor from the centre, in baselines."""
    return float(np.linalg.norm(places(name), axis=1).max())


def trace_free(components: Array) -> Array:
    """Return G (3, 3) of components Bxx, Bxy, Bxz, Byy, Byz (5,)."""
    xx, xy, xz, yy, yz = components
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, -xx - yy]])


def operator(place_m: Array) -> Array:
    """Return the matrix (5, 3 k) from the sensors' fields, one after another, to the components of G."""
    unit = [trace_free(one) for one in np.eye(5)]
    rows = [np.hstack((np.eye(3), np.stack([G @ r for G in unit], axis=1))) for r in place_m]
    return np.asarray(np.linalg.pinv(np.concatenate(rows))[3:])


def tensors(place_m: Array, field_nT: Array) -> Array:
    """Return the components (n, 5) of G, nT/m, from fields (k, n, 3) at places (k, 3)."""
    return np.asarray(np.concatenate(field_nT, axis=1) @ operator(place_m).T)

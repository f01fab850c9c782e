"""Start ellipsoids of a fit, for any motion."""

from __future__ import annotations

import numpy as np

from calib.models.ellipsoid import UPPER, Ellipsoid
from calib.models.quadric import fit_ellipsoid_specific, refit
from calib.models.sphere import SphereFit
from scenarios.arrays import Array

START_ROUNDS = 4
"""Refits of the algebraic start: each takes off most of the bias that the one before left."""


def starts(x: Array) -> list[Array]:
    """Start ellipsoids q (9,): the sphere, and the noise-adjusted algebraic ellipsoid if real."""
    sphere = SphereFit.of(x)
    found = [np.concatenate((sphere.centre, sphere.radius * np.eye(3)[UPPER]))]
    theta, last = fit_ellipsoid_specific(x), None
    for _ in range(START_ROUNDS):
        ellipsoid = Ellipsoid.of_quadric(theta)
        if ellipsoid is None:
            break
        last, theta = ellipsoid, refit(x, theta).theta
    return found if last is None else [*found, np.concatenate((last.centre, last.root[UPPER]))]

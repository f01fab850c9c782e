"""The turn between two survey lines: half a turn of heading with continuous curvature."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from scenarios.arrays import Array
from scenarios.paths.jet import run

EASE = 0.3
"""Share of the turn's length over which the curvature rises, and again falls."""
KNOTS = 513
OUTER, INNER = (math.sqrt(5.0 + side * 2.0 * math.sqrt(10.0 / 7.0)) / 3.0 for side in (1.0, -1.0))
NODES = np.array([-OUTER, -INNER, 0.0, INNER, OUTER])
HEAVY, LIGHT = ((322.0 + side * 13.0 * math.sqrt(70.0)) / 900.0 for side in (1.0, -1.0))
WEIGHTS = np.array([LIGHT, HEAVY, 128.0 / 225.0, HEAVY, LIGHT])
"""Nodes and weights of the five-point Gauss-Legendre rule on [-1, 1], in closed form."""


def heading(u: Array) -> tuple[Array, Array, Array]:
    """Return heading and its first two derivatives in u, u = length / length of the turn in [0, 1].

    theta(0) = 0, theta(1) = pi; the curvature theta' is zero at both ends, constant between, and smooth.
    """
    theta = run(u, 0.0, np.pi / (1.0 - EASE), EASE, 1.0 - EASE)
    return theta.x, theta.dx, theta.ddx


@cache
def unit_turn() -> tuple[CubicHermiteSpline, float]:
    """Return the plane position (ahead, aside) in a turn of unit length over u, and the width of the turn.

    Integral of (cos theta, sin theta), five-point Gauss quadrature between knots; the table serves turns of any size.
    By symmetry the turn ends exactly abeam of the start, at (0, width).
    """
    knots = np.linspace(0.0, 1.0, KNOTS)
    half = 0.5 / (KNOTS - 1)
    inside = heading((knots[:-1, None] + half * (1.0 + NODES)).ravel())[0].reshape(-1, NODES.size)
    ways = np.stack([np.cos(inside), np.sin(inside)], axis=-1)
    steps = half * np.sum(ways * WEIGHTS[:, None], axis=1)
    points = np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])
    theta = heading(knots)[0]
    return CubicHermiteSpline(knots, points, np.column_stack([np.cos(theta), np.sin(theta)])), float(points[-1, 1])

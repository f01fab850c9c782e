"""Distances to an ellipsoid against a search over all directions, a sphere, and finite differences."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize

from calib.models.distance import distances, slopes
from calib.models.ellipsoid import symmetric

SEMI = np.array([0.7, 1.0, 1.6])
AXES = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
CENTRE = np.array([0.3, -0.2, 0.5])
ROOT = AXES @ np.diag(SEMI) @ AXES.T
Q = np.concatenate((CENTRE, ROOT[np.triu_indices(3)]))


def points(count: int) -> np.ndarray:
    """Near, far out, and deep inside."""
    return CENTRE + np.random.default_rng(1).normal(size=(count, 3)) * 1.2


def found(q: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, ...]:
    semi, axes = np.linalg.eigh(symmetric(q[3:]))
    return distances(x, q[:3], semi, axes)


def test_no_direction_is_nearer():
    x = points(10)
    starts = np.random.default_rng(2).normal(size=(4, 3))

    def off(s, one):
        return np.sum((one - CENTRE - ROOT @ (s / np.linalg.norm(s))) ** 2)

    least = [min(minimize(off, s, args=(one,), tol=1e-14).fun for s in starts) for one in x]
    np.testing.assert_allclose(np.abs(found(Q, x)[0]), np.sqrt(least), atol=1e-7)


def test_point_is_the_foot_and_the_distance_along_the_normal():
    x = points(500)
    d, direction, normal, _ = found(Q, x)
    np.testing.assert_allclose(np.linalg.norm(direction, axis=1), 1.0, atol=1e-12)
    np.testing.assert_allclose(CENTRE + direction @ ROOT + d[:, None] * normal, x, atol=1e-11)
    outside = np.linalg.norm((x - CENTRE) @ np.linalg.inv(ROOT), axis=1) > 1.0
    np.testing.assert_array_equal(d > 0, outside)


def test_slopes_are_those_of_the_distance():
    x = points(50)
    _, direction, normal, _ = found(Q, x)
    for k, step in enumerate(1e-6 * np.eye(9)):
        slope = (found(Q + step, x)[0] - found(Q - step, x)[0]) / 2e-6
        np.testing.assert_allclose(slopes(direction, normal)[:, k], slope, atol=1e-7)


def test_noise_along_the_surface_lengthens_the_distance_by_the_mean_curvature():
    rng = np.random.default_rng(3)
    foot = CENTRE + ROOT @ np.array([0.6, 0.0, 0.8])
    std = 0.03
    d, _, _, curvature = found(Q, foot + rng.normal(0.0, std, (400_000, 3)))
    expected = std**2 * found(Q, foot[None])[3][0]
    assert np.mean(d) == pytest.approx(expected, abs=5 * std / np.sqrt(len(d)))
    assert expected > 10 * std / np.sqrt(len(d))
    sphere = distances(points(10), CENTRE, np.full(3, 2.0), np.eye(3))
    np.testing.assert_allclose(sphere[3], 0.5)
    assert curvature.min() > 0


def test_centre_is_as_far_inside_as_the_shortest_axis():
    d, direction, normal, _ = found(Q, CENTRE[None])
    assert d[0] == pytest.approx(-SEMI[0])
    np.testing.assert_allclose(direction[0] @ ROOT + d[0] * normal[0], 0.0, atol=1e-12)

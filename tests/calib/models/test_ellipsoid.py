"""One ellipsoid by two coordinates: conversions, derivatives, and one covariance whichever way."""

from __future__ import annotations

import numpy as np
import pytest

from calib.models.ellipsoid import (
    UPPER,
    CentralForm,
    Ellipsoid,
    EllipsoidFit,
    Standardised,
    mean_square_error,
    norm_jacobian,
    symmetric_root,
)
from calib.models.quadric import design, fit_ellipsoid_specific, refit, shape_matrix

CENTRE = np.array([0.3, -0.2, 0.5])
ROOT = np.array([[1.1, 0.05, -0.02], [0.05, 0.9, 0.03], [-0.02, 0.03, 1.0]])
TRUE = Ellipsoid(CENTRE, ROOT)


def sphere_points(n: int = 200, seed: int = 0) -> np.ndarray:
    h = np.random.default_rng(seed).normal(size=(n, 3))
    return np.asarray(h / np.linalg.norm(h, axis=1)[:, None])


def quadric_of(ellipsoid: Ellipsoid, factor: float = 1.0) -> np.ndarray:
    """theta (10,) of (x - centre)^T root^-2 (x - centre) = 1, times a factor."""
    A = np.linalg.inv(ellipsoid.root @ ellipsoid.root)
    p = -A @ ellipsoid.centre
    d = ellipsoid.centre @ A @ ellipsoid.centre - 1.0
    return np.asarray(factor * np.array([A[0, 0], A[1, 1], A[2, 2], A[1, 2], A[0, 2], A[0, 1], *p, d]))


def values(ellipsoid: Ellipsoid | None) -> np.ndarray:
    assert ellipsoid is not None
    return np.concatenate((ellipsoid.centre, ellipsoid.root[UPPER]))


def test_norm_coordinates_there_and_back() -> None:
    np.testing.assert_allclose(values(Ellipsoid.of_norm(TRUE.norm)), values(TRUE), rtol=1e-12)
    x = sphere_points() @ ROOT + CENTRE
    T, c = np.linalg.inv(ROOT), TRUE.norm[6:]
    np.testing.assert_allclose(np.linalg.norm(x @ T - c, axis=1), 1.0, rtol=1e-12)


@pytest.mark.parametrize("factor", [1.0, 0.02, 300.0])
def test_quadric_of_any_scale_is_the_ellipsoid(factor: float) -> None:
    np.testing.assert_allclose(values(Ellipsoid.of_quadric(quadric_of(TRUE, factor))), values(TRUE), rtol=1e-12)


def test_no_ellipsoid() -> None:
    hyperboloid, imaginary = quadric_of(TRUE), quadric_of(TRUE)
    hyperboloid[2] = -hyperboloid[2]
    imaginary[9] += 1.5
    assert Ellipsoid.of_quadric(hyperboloid) is None
    assert Ellipsoid.of_quadric(imaginary) is None
    assert EllipsoidFit.of_quadric(hyperboloid, np.eye(10), 1.0) is None


def test_jacobians_against_differences() -> None:
    for jacobian, of, at in (
        (norm_jacobian, Ellipsoid.of_norm, TRUE.norm),
        (lambda theta: CentralForm.of(theta).jacobian, Ellipsoid.of_quadric, quadric_of(TRUE, 0.7)),
    ):
        steps = 1e-6 * np.eye(len(at))
        slopes = [(values(of(at + s)) - values(of(at - s))) / 2e-6 for s in steps]
        np.testing.assert_allclose(jacobian(at), np.array(slopes).T, rtol=1e-6, atol=1e-7)


def test_both_coordinates_give_one_covariance() -> None:
    """A norm covariance carried to the quadric by differences, and through it."""
    rng = np.random.default_rng(1)
    root = rng.normal(size=(9, 9)) * 1e-3
    p, steps = TRUE.norm, 1e-6 * np.eye(9)
    carried = np.array(
        [(quadric_of(Ellipsoid.of_norm(p + s)) - quadric_of(Ellipsoid.of_norm(p - s))) / 2e-6 for s in steps]
    )
    one = EllipsoidFit.of_norm(p, root @ root.T, 1.0)
    other = EllipsoidFit.of_quadric(quadric_of(TRUE), carried.T @ root @ root.T @ carried, 1.0)
    assert other is not None
    np.testing.assert_allclose(other.covariance, one.covariance, rtol=1e-6, atol=1e-12)


def test_error_of_a_linear_fit_by_simulation() -> None:
    """Noise that is not white in a line's fit, and a known bias."""
    rng = np.random.default_rng(2)
    rows, std = rng.normal(size=(60, 2)), np.where(np.arange(60) < 30, 0.1, 0.5)
    H = rows.T @ rows
    found = rng.normal(0.0, std, (20_000, 60)) @ rows @ np.linalg.inv(H)
    meat = rows.T @ (rows * std[:, None] ** 2)
    np.testing.assert_allclose(mean_square_error(H, 1.0, meat), np.cov(found.T), rtol=0.1, atol=1e-4)
    plain = mean_square_error(H, 0.3)
    np.testing.assert_allclose(plain, 0.3 * np.linalg.inv(H), rtol=1e-12)
    gradient = np.array([3.0, -2.0])
    delta = 0.3 * np.linalg.solve(H, gradient)
    np.testing.assert_allclose(mean_square_error(H, 0.3, bias=gradient) - plain, np.outer(delta, delta), rtol=1e-9)


def test_symmetric_root() -> None:
    np.testing.assert_allclose(symmetric_root(ROOT @ ROOT), ROOT, rtol=1e-12)


@pytest.mark.parametrize("seed", range(12))
def test_ellipsoid_specific_start_is_exact_without_noise(seed: int) -> None:
    """Any place and shape, with axes within the factor of two that the constraint admits, and positive inside out."""
    rng = np.random.default_rng(seed)
    axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    true = Ellipsoid(rng.normal(size=3) * 2.0, (axes * rng.uniform(0.8, 1.4, 3)) @ axes.T)
    x = sphere_points(100, seed) @ true.root + true.centre
    theta = fit_ellipsoid_specific(x)
    np.testing.assert_allclose(values(Ellipsoid.of_quadric(theta)), values(true), rtol=1e-6, atol=1e-7)
    assert theta[:3].sum() > 0
    far = np.array([[100.0, 0.0, 0.0]])
    assert design(far)[0] @ theta[:9] + theta[9] > 0
    assert np.linalg.eigvalsh(shape_matrix(theta))[0] > 0
    again = refit(x + rng.normal(0.0, 1e-3, x.shape), theta)
    assert again.theta[:3].sum() > 0
    assert again.noise_std == pytest.approx(1e-3, rel=0.35)


def test_ellipsoid_specific_start_is_an_ellipsoid_where_the_plain_fit_is_none() -> None:
    """A noisy cap, through which a hyperboloid goes best."""
    h = sphere_points(4000, 3)
    cap = h[h[:, 2] > 0.93] * [1.0, 1.0, 1.0]
    x = Standardised.of(cap + np.random.default_rng(4).normal(0.0, 0.02, cap.shape)).x
    assert Ellipsoid.of_quadric(refit(x, fit_ellipsoid_specific(x)).theta) is None
    assert Ellipsoid.of_quadric(fit_ellipsoid_specific(x)) is not None

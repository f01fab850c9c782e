"""Rotations against scipy's."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from sim.rotation import (
    cross,
    matrix_from_q,
    multiply_q,
    q_from_matrix,
    q_from_rotation_vector,
    to_body,
)

RNG = np.random.default_rng(3)
R = Rotation.random(50, RNG)
Q = np.ascontiguousarray(np.roll(R.as_quat(canonical=True), 1, axis=1))


def test_matrix_and_quaternion() -> None:
    np.testing.assert_allclose(matrix_from_q(Q), R.as_matrix(), atol=1e-14)
    np.testing.assert_allclose(q_from_matrix(R.as_matrix()), Q, atol=1e-14)


def test_product_turns_first_by_the_right_factor() -> None:
    product = matrix_from_q(multiply_q(Q[:25], Q[25:]))
    np.testing.assert_allclose(product, (R[:25] * R[25:]).as_matrix(), atol=1e-14)


def test_rotation_vector_down_to_zero() -> None:
    v = np.concatenate([RNG.standard_normal((20, 3)), 1e-9 * RNG.standard_normal((5, 3)), np.zeros((1, 3))])
    np.testing.assert_allclose(
        matrix_from_q(q_from_rotation_vector(v)), Rotation.from_rotvec(v).as_matrix(), atol=1e-14
    )


def test_to_body_is_the_inverse_rotation() -> None:
    v = RNG.standard_normal((50, 3))
    np.testing.assert_allclose(to_body(R.as_matrix(), v), R.inv().apply(v), atol=1e-14)
    np.testing.assert_allclose(to_body(R.as_matrix(), v[:1]), R.inv().apply(v[0]), atol=1e-14)


def test_cross() -> None:
    a, b = RNG.standard_normal((2, 50, 3))
    np.testing.assert_allclose(cross(a, b), np.cross(a, b), atol=1e-15)
    np.testing.assert_allclose(cross(a[:1], b), np.cross(a[:1], b), atol=1e-15)

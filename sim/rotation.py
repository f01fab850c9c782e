"""Quaternions (w, x, y, z; body to world) and rotation matrices, for whole arrays."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from scenarios.arrays import Array
from scenarios.kernel_cache import njit


@njit(cache=True)
def matrix_from_q(q: Array) -> Array:
    """R_wb (n, 3, 3) of unit quaternions q (n, 4): v_world = R_wb v_body."""
    out = np.empty((q.shape[0], 3, 3))
    for i in range(q.shape[0]):
        w, x, y, z = q[i, 0], q[i, 1], q[i, 2], q[i, 3]
        out[i, 0, 0] = 1.0 - 2.0 * (y * y + z * z)
        out[i, 0, 1] = 2.0 * (x * y - w * z)
        out[i, 0, 2] = 2.0 * (x * z + w * y)
        out[i, 1, 0] = 2.0 * (x * y + w * z)
        out[i, 1, 1] = 1.0 - 2.0 * (x * x + z * z)
        out[i, 1, 2] = 2.0 * (y * z - w * x)
        out[i, 2, 0] = 2.0 * (x * z - w * y)
        out[i, 2, 1] = 2.0 * (y * z + w * x)
        out[i, 2, 2] = 1.0 - 2.0 * (x * x + y * y)
    return out


@njit(cache=True, nogil=True)
def to_body(R_wb: Array, v_world: Array) -> Array:
    """R_wb^T v: world vectors (n, 3), or a constant one (1, 3), in body frames (n, 3)."""
    out = np.empty((R_wb.shape[0], 3))
    for i in range(R_wb.shape[0]):
        v = v_world[i] if v_world.shape[0] > 1 else v_world[0]
        for j in range(3):
            out[i, j] = R_wb[i, 0, j] * v[0] + R_wb[i, 1, j] * v[1] + R_wb[i, 2, j] * v[2]
    return out


@njit(cache=True)
def to_world(R_wb: Array, v_body: Array) -> Array:
    """R_wb v: body vectors (n, 3), or a constant one (1, 3), in the world (n, 3)."""
    out = np.empty((R_wb.shape[0], 3))
    for i in range(R_wb.shape[0]):
        v = v_body[i] if v_body.shape[0] > 1 else v_body[0]
        for j in range(3):
            out[i, j] = R_wb[i, j, 0] * v[0] + R_wb[i, j, 1] * v[1] + R_wb[i, j, 2] * v[2]
    return out


@njit(cache=True)
def cross(a: Array, b: Array) -> Array:
    """Row-wise a x b of (n, 3) arrays; either may have one row."""
    n = max(a.shape[0], b.shape[0])
    out = np.empty((n, 3))
    for i in range(n):
        u = a[i] if a.shape[0] > 1 else a[0]
        v = b[i] if b.shape[0] > 1 else b[0]
        out[i, 0] = u[1] * v[2] - u[2] * v[1]
        out[i, 1] = u[2] * v[0] - u[0] * v[2]
        out[i, 2] = u[0] * v[1] - u[1] * v[0]
    return out


@njit(cache=True)
def multiply_q(p: Array, q: Array) -> Array:
    """Row-wise quaternion product p q (n, 4): first q, then p."""
    out = np.empty_like(q)
    for i in range(q.shape[0]):
        a, b, c, d = p[i, 0], p[i, 1], p[i, 2], p[i, 3]
        w, x, y, z = q[i, 0], q[i, 1], q[i, 2], q[i, 3]
        out[i, 0] = a * w - b * x - c * y - d * z
        out[i, 1] = a * x + b * w + c * z - d * y
        out[i, 2] = a * y - b * z + c * w + d * x
        out[i, 3] = a * z + b * y - c * x + d * w
    return out


def q_from_rotation_vector(v: Array) -> Array:
    """Unit quaternions (n, 4) of rotation vectors v (n, 3) in radians."""
    half = 0.5 * v
    angle = np.linalg.norm(half, axis=1, keepdims=True)
    return np.concatenate([np.cos(angle), half * np.sinc(angle / np.pi)], axis=1)


def q_from_matrix(R: Array) -> Array:
    """Unit quaternions (n, 4), w >= 0, of rotation matrices (n, 3, 3)."""
    xyzw = Rotation.from_matrix(R).as_quat(canonical=True)
    return np.asarray(np.roll(xyzw, 1, axis=-1))

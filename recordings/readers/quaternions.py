"""Products and turns of quaternions w x y z."""

from __future__ import annotations

import numpy as np

from scenarios.arrays import Array


def product(p: Array, q: Array) -> Array:
    """Return the product p q of quaternions (..., 4), w x y z: first q turns, then p."""
    (a, b, c, d), (w, x, y, z) = np.moveaxis(p, -1, 0), np.moveaxis(q, -1, 0)
    parts = (
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    )
    return np.stack(parts, axis=-1)


def rotated(q: Array, vectors: Array) -> Array:
    """Return vectors (n, 3) turned by unit quaternions (4,) or (n, 4): v + 2 w u x v + 2 u x (u x v), q = (w, u)."""
    w, u = q[..., :1], q[..., 1:]
    across = np.cross(u, vectors)
    return np.asarray(vectors + 2 * w * across + 2 * np.cross(u, across))


def inverse(q: Array) -> Array:
    """Return the inverse of unit quaternions (..., 4)."""
    return np.asarray(q * np.array([1.0, -1.0, -1.0, -1.0]))


def of_angles(angles: Array) -> Array:
    """Return quaternions (n, 4) of roll, pitch, yaw (n, 3) about x, y, z, yaw outermost."""
    zero = np.zeros(len(angles))
    cosine, sine = np.cos(angles.T / 2), np.sin(angles.T / 2)
    roll, pitch, yaw = (
        np.column_stack([cosine[k], *(sine[k] if axis == k else zero for axis in range(3))]) for k in range(3)
    )
    return product(yaw, product(pitch, roll))


def of_matrices(matrix: Array) -> Array:
    """Return quaternions (n, 4) of rotations (n, 3, 3): the eigenvector of K's largest eigenvalue.

    K = [[m00 + m11 + m22, v^T], [v, m + m^T - (m00 + m11 + m22) I]],  v = (m21 - m12, m02 - m20, m10 - m01).
    """
    k = np.zeros((len(matrix), 4, 4))
    trace = np.trace(matrix, axis1=1, axis2=2)
    skew = matrix - matrix.transpose(0, 2, 1)
    k[:, 0, 0] = trace
    k[:, 0, 1:] = k[:, 1:, 0] = np.column_stack([skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]])
    k[:, 1:, 1:] = matrix + matrix.transpose(0, 2, 1) - trace[:, None, None] * np.eye(3)
    k[~np.isfinite(k).all(axis=(1, 2))] = np.eye(4)
    return np.asarray(np.linalg.eigh(k)[1][:, :, -1])

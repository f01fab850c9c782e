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
    """Return quaternions (n, 4) of rotations (n, 3, 3), by the largest of the four components [Shepperd1978]."""
    m = matrix.transpose(1, 2, 0)
    square = np.stack([m[0, 0] + m[1, 1] + m[2, 2], *(2 * m[k, k] - m[0, 0] - m[1, 1] - m[2, 2] for k in range(3))])
    d, s = (lambda i, j: m[i, j] - m[j, i]), (lambda i, j: m[i, j] + m[j, i])
    rows = (
        (1 + square[0], d(2, 1), d(0, 2), d(1, 0)),
        (d(2, 1), 1 + square[1], s(0, 1), s(0, 2)),
        (d(0, 2), s(0, 1), 1 + square[2], s(1, 2)),
        (d(1, 0), s(0, 2), s(1, 2), 1 + square[3]),
    )
    every = np.array([np.stack(row) for row in rows])
    q = every[np.argmax(square, axis=0), :, np.arange(matrix.shape[0])]
    return np.asarray(q / np.maximum(np.linalg.norm(q, axis=1, keepdims=True), 1e-12))

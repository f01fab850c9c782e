"""Where a fit of linked directions begins: what the gyro says by itself, an ellipsoid, a sphere."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from calib.models.ellipsoid import SLOTS, Standardised, is_definite, symmetric
from calib.models.linked import LinkedEstimate, LinkedSamples
from calib.models.starts import starts as ellipsoids
from calib.numerics.points import cross_matrices
from scenarios.arrays import Array

TURNED_RAD = 0.7
"""Rotation over which measurements are compared: large beside the noise, small beside what a gyro's bias adds up to."""
FAR_RAD = 0.5
"""Axes turned by more than this are no start: the steps are made for small turns."""
MOST_SHARE = 4
"""The comparison spans at most this part of the recording."""


def starts(link: LinkedSamples) -> list[LinkedEstimate]:
    """Estimates to start from, the gyro's bias at zero."""
    own = Standardised.of(link.x)
    shapes = [(own.middle_nT + own.scale_nT * q[:3], own.scale_nT * symmetric(q[3:])) for q in ellipsoids(own.x)]
    linear = turned_alike(link)
    return [
        _turned(link, LinkedEstimate.of(link.x, *shape)) for shape in (shapes if linear is None else [*shapes, linear])
    ]


def _turned(link: LinkedSamples, e: LinkedEstimate) -> LinkedEstimate:
    """The estimate in the gyro's axes, where they are turned far from its own and S may have nine entries."""
    Q = axes_of_gyro(link, e.directions)
    far = (np.trace(Q) - 1.0) / 2.0 < np.cos(FAR_RAD)
    return LinkedEstimate.of(link.x, e.centre, e.root @ Q) if far and len(link.slots) == Q.size else e


def axes_of_gyro(link: LinkedSamples, u: Array) -> Array:
    """The rotation Q (3, 3) from the gyro's axes to those of directions u (n, 3), by what both see of the motion.

    u_(i+1) - u_i = u x (Q omega - beta) dt,  u the mean of both: linear least squares in Q and beta, then the rotation
    that is nearest to Q. [Markley1988]
    """
    mean = cross_matrices((u[1:] + u[:-1]) / 2) * link.step_s[:, None, None]
    rows = np.concatenate(
        ((mean[:, :, :, None] * link.rate_rad_s[:, None, None, :]).reshape(-1, 9), -mean.reshape(-1, 3)), 1
    )
    change = np.where(link.step_s[:, None] > 0, np.diff(u, axis=0), 0.0)
    left, _, right = np.linalg.svd(np.linalg.lstsq(rows, change.ravel(), rcond=None)[0][:9].reshape(3, 3))
    return np.asarray(left @ np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))]) @ right)


def turned_alike(link: LinkedSamples) -> tuple[Array, Array] | None:
    """Centre (3,) and root (3, 3) by linear least squares on what the gyro says, taken as having no bias.

    T x_j - d = R (T x_i - d),  R the rotation from sample i to j, tr T = 3;  then |T x - d| = 1 on the average.
    T symmetric; None where it is not positive definite.
    """
    flat = _differences(link).reshape(-1, 9)
    free = np.column_stack((flat[:, 0] - flat[:, 5], flat[:, 3] - flat[:, 5], flat[:, [1, 2, 4, 6, 7, 8]]))
    a, b, *rest = np.linalg.lstsq(free, -flat[:, [0, 3, 5]].sum(axis=1), rcond=None)[0]
    T, d = symmetric(np.array([1 + a, rest[0], rest[1], 1 + b, rest[2], 1 - a - b])), np.array(rest[3:])
    if not is_definite(T):
        return None
    size = float(np.mean(np.linalg.norm(link.x @ T - d, axis=1)))
    root = np.asarray(np.linalg.inv(T), dtype=np.float64)
    return root @ d, size * root


def _differences(link: LinkedSamples) -> Array:
    """d (T x_j - d - R (T x_i - d)) / d (T's six, d): (m, 3, 9), over windows that turn by some TURNED_RAD."""
    turns = Rotation.from_rotvec(-link.rate_rad_s * link.step_s[:, None])
    angle = float(np.sqrt(np.mean(turns.magnitude() ** 2)))
    window = TURNED_RAD / angle if angle > 0 else np.inf
    R, length = _windows(turns, int(np.clip(window, 1, len(turns) // MOST_SHARE)))
    first, last = link.x[: len(R)], link.x[length : length + len(R)]
    return np.asarray(_designed(last) - R @ _designed(first))


def _designed(x: Array) -> Array:
    """d (T x - d) / d (T's six, d): (n, 3, 9)."""
    return np.asarray(np.einsum("ipk,nk->nip", SLOTS, np.column_stack((x, np.ones(len(x))))))


def _windows(steps: Rotation, window: int) -> tuple[Array, int]:
    """Rotations (m, 3, 3) over windows of a power of two of steps, at most `window`, by doubling."""
    length = 1
    while 2 * length <= window:
        steps, length = steps[length:] * steps[:-length], 2 * length
    return steps.as_matrix(), length

"""Small matrices of the sensor's geometry: rotations and triangular axes, with the inverse functions for the angles."""

from __future__ import annotations

import math

import numpy as np
from scipy.linalg import rq

from scenarios.arrays import Array
from sim.effects.parameters import Vec3
from sim.portable_arithmetic import product


def rotation_about(axis: int, angle_deg: float) -> Array:
    """Rotation of vectors about x (0), y (1) or z (2)."""
    c, s = math.cos(math.radians(angle_deg)), math.sin(math.radians(angle_deg))
    i, j = (axis + 1) % 3, (axis + 2) % 3
    R = np.eye(3)
    R[i, i], R[i, j], R[j, i], R[j, j] = c, -s, s, c
    return R


def rotation(angles_deg: Vec3) -> Array:
    """Rz(z) Ry(y) Rx(x) for angles (x, y, z)."""
    x, y, z = angles_deg
    return product(product(rotation_about(2, z), rotation_about(1, y)), rotation_about(0, x))


def rotation_angles_deg(R: Array) -> Vec3:
    """Angles (x, y, z) of a rotation R = Rz Ry Rx; x is 0 where y is +-90 degrees and only x and z together count."""
    y = math.asin(min(1.0, max(-1.0, -R[2, 0])))
    if math.hypot(R[2, 1], R[2, 2]) < 1e-12:
        return (0.0, math.degrees(y), math.degrees(math.atan2(-R[0, 1], R[1, 1])))
    x, z = math.atan2(R[2, 1], R[2, 2]), math.atan2(R[1, 0], R[0, 0])
    return (math.degrees(x), math.degrees(y), math.degrees(z))


def zhang_installation(angles_deg: Vec3) -> Array:
    """[Zhang2018] eq. 2, symmetric: ``[[1, -sin z, sin y], [-sin z, 1, -sin x], [sin y, -sin x, 1]]``."""
    x, y, z = (math.sin(math.radians(angle)) for angle in angles_deg)
    return np.array([[1.0, -z, y], [-z, 1.0, -x], [y, -x, 1.0]])


def triangular(angles_deg: Vec3) -> Array:
    """Upper-triangular matrix with unit rows from the angles (xy, xz, yz), [Zhang2018] eq. 3.

    ``[[cos xz cos xy, sin xy, sin xz cos xy], [0, cos yz, sin yz], [0, 0, 1]]``.
    """
    xy, xz, yz = (math.radians(angle) for angle in angles_deg)
    first = (math.cos(xz) * math.cos(xy), math.sin(xy), math.sin(xz) * math.cos(xy))
    return np.array([first, (0.0, math.cos(yz), math.sin(yz)), (0.0, 0.0, 1.0)])


def triangular_angles_deg(N: Array) -> Vec3:
    """Angles (xy, xz, yz) of an upper-triangular matrix with unit rows."""
    xy, xz = math.asin(min(1.0, max(-1.0, N[0, 1]))), math.atan2(N[0, 2], N[0, 0])
    return (math.degrees(xy), math.degrees(xz), math.degrees(math.atan2(N[1, 2], N[1, 1])))


def axes_and_turn(A: Array) -> tuple[Array, Array]:
    """A = N Q: upper-triangular N with a positive diagonal, and a rotation Q, for det A > 0 (RQ decomposition)."""
    N, Q = rq(A)
    sign = np.sign(np.diag(N))
    return N * sign, sign[:, None] * Q

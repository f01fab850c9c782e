"""An array of magnetometers in a uniform field: twelve parameters a sensor, the gradient tensor, and the objective.

b_i = K_i C_i T_i^-1 h + b:  h = T_gamma T_alpha T_beta (K C)^-1 (m - b), h in the frame of sensor 1  [Ding2021] eq. 6.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from calib.models.quadric import design
from calib.numerics.kernels import fast_kernel
from scenarios.arrays import Array

SENSOR_NAMES = (
    "offset_x_nT",
    "offset_y_nT",
    "offset_z_nT",
    "scale_x",
    "scale_y",
    "scale_z",
    "psi_deg",
    "phi_deg",
    "theta_deg",
    "alpha_deg",
    "beta_deg",
    "gamma_deg",
)
"""The parameters of one sensor, in the order of a parameter vector (which has offsets over F, and radians)."""
PER_SENSOR = len(SENSOR_NAMES)
FIXED = (9, 10, 11)
"""Sensor 1's misalignment: no turn of the whole array is observable, so sensor 1 is the reference."""
TENSOR_NAMES = ("Bxx", "Bxy", "Bxz", "Byy", "Byz")
CROSS = 4


class ArrayObjective(NamedTuple):
    """What the objective needs of a recording of k sensors, field in units of F; see `array_objective`.

    total (k, 10, 10) and pair (p, 7, 7): triangular factors of the designs of totals and of pairs of sensors;
    pairs (p, 2); weight (p, 3): root weight of a pair's components; field (k, n, 3), invariant_weight: invariants.
    """

    total: Array
    pair: Array
    pairs: NDArray[np.int64]
    weight: Array
    field: Array
    invariant_weight: float


def array_objective(
    array_mag_nT: Array, strength_nT: float, components: float = 1.0, tensor: float = 1.0, invariants: float = 0.0
) -> ArrayObjective:
    """The objective of a recording (k, n, 3), [Ding2021] eq. 17 in mean squares, in units of F^2.

    J = sum_i <((|h_i|^2 - F^2) / 2F)^2> + components / k sum_(i<j) <|h_i - h_j|^2>
        + tensor d^2 <Bxx^2 + Bxy^2 + Bxz^2 + Byy^2 + Byz^2> + invariants <d^2 |I1| + d^2 |I2|^(2/3) + d^2 mu^2>

    (|h|^2 - F^2) / 2F is |h| - F to first order. All but the last term are sums of squares of what is linear in
    monomials of m: a QR of those shortens n samples to 10 rows a sensor and 7 a pair, with the same sum of squares. The
    weights are ours (the paper's formula is lost in print); tensor terms need the cross of four. The invariants are
    made of degree one in G, evaluated sample by sample, and left out unless they get a weight: they are functions of
    the five components, which they repeat.
    """
    x = np.ascontiguousarray(array_mag_nT / strength_nT)
    k, n = x.shape[:2]
    ones = np.ones((n, 1))
    pairs = np.array([(i, j) for i in range(k) for j in range(i + 1, k)])
    weight = np.full((len(pairs), 3), components / k)
    if k == CROSS:
        weight[1] += tensor
        weight[4, 1:] += tensor
    total = [_triangle(np.hstack((design(one), ones))) for one in x]
    pair = [_triangle(np.hstack((x[i], x[j], ones))) for i, j in pairs]
    return ArrayObjective(np.array(total), np.array(pair), pairs, np.sqrt(weight), x, invariants if k == CROSS else 0.0)


def _triangle(rows: Array) -> Array:
    """R (p, p) with |R v|^2 = <(row v)^2>."""
    padded = np.vstack((rows, np.zeros((max(rows.shape[1] - len(rows), 0), rows.shape[1]))))
    return np.asarray(np.linalg.qr(padded).R / math.sqrt(len(rows)))


@fast_kernel
def sensor_matrix(p: Array, matrix: Array) -> None:
    """Fill matrix (3, 3) = T_gamma T_alpha T_beta (K C)^-1 of one sensor's parameters (12,)."""
    a, b, c = math.cos(p[7]) * math.cos(p[8]), math.cos(p[7]) * math.sin(p[8]), math.sin(p[7])
    cp, tp = math.cos(p[6]), math.tan(p[6])
    u00, u01, u02 = 1 / (a * p[3]), -b / (a * cp * p[4]), (b * tp - c) / (a * p[5])
    u11, u12, u22 = 1 / (cp * p[4]), -tp / p[5], 1 / p[5]
    ca, sa, cb, sb = math.cos(p[9]), math.sin(p[9]), math.cos(p[10]), math.sin(p[10])
    cg, sg = math.cos(p[11]), math.sin(p[11])
    t = (
        (cg * cb + sg * sa * sb, sg * ca, -cg * sb + sg * sa * cb),
        (-sg * cb + cg * sa * sb, cg * ca, sg * sb + cg * sa * cb),
        (ca * sb, -sa, ca * cb),
    )
    for r in range(3):
        matrix[r, 0] = t[r][0] * u00
        matrix[r, 1] = t[r][0] * u01 + t[r][1] * u11
        matrix[r, 2] = t[r][0] * u02 + t[r][1] * u12 + t[r][2] * u22


@fast_kernel
def fill_maps(p: Array, matrix: Array, shift: Array) -> None:
    """Fill matrix (k, 3, 3) and shift (k, 3) of h_i = matrix_i x - shift_i from parameters (12 k,)."""
    for i in range(len(matrix)):
        q = p[12 * i : 12 * i + 12]
        sensor_matrix(q, matrix[i])
        for r in range(3):
            shift[i, r] = matrix[i, r, 0] * q[0] + matrix[i, r, 1] * q[1] + matrix[i, r, 2] * q[2]


def maps(p: Array, k: int) -> tuple[Array, Array]:
    """Matrices (k, 3, 3) and shifts (k, 3) of k sensors, see `fill_maps`."""
    matrix, shift = np.empty((k, 3, 3)), np.empty((k, 3))
    fill_maps(p, matrix, shift)
    return matrix, shift


@fast_kernel
def total_residuals(R: Array, m: Array, s: Array, out: Array) -> None:
    """(|h|^2 - 1) / 2 of one sensor, through its factor: the quadric theta of h = m x - s."""
    theta = np.empty(10)
    for e, (i, j) in enumerate(((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))):
        theta[e] = 0.5 * (m[0, i] * m[0, j] + m[1, i] * m[1, j] + m[2, i] * m[2, j])
    for i in range(3):
        theta[6 + i] = -0.5 * (m[0, i] * s[0] + m[1, i] * s[1] + m[2, i] * s[2])
    theta[9] = 0.5 * (s[0] * s[0] + s[1] * s[1] + s[2] * s[2] - 1.0)
    for r in range(10):
        value = 0.0
        for c in range(r, 10):
            value += R[r, c] * theta[c]
        out[r] = value


@fast_kernel
def pair_residuals(R: Array, weight: Array, m: Array, s: Array, n: Array, t: Array, out: Array) -> None:
    """h_i - h_j of a pair of sensors, through its factor: 7 values for each of x, y, z."""
    v = np.empty(7)
    for axis in range(3):
        for c in range(3):
            v[c], v[3 + c] = m[axis, c], -n[axis, c]
        v[6] = t[axis] - s[axis]
        for r in range(7):
            value = 0.0
            for c in range(r, 7):
                value += R[r, c] * v[c]
            out[7 * axis + r] = weight[axis] * value


@fast_kernel
def mean_invariants(field: Array, matrix: Array, shift: Array) -> tuple[float, float, float]:
    """Means of d^2 |I1|, d^2 |I2|^(2/3), d^2 mu^2 over the samples of a cross of four; see `invariants`."""
    first, second, third = 0.0, 0.0, 0.0
    g, h = np.empty(6), np.empty((4, 3))
    for n in range(field.shape[1]):
        for i in range(len(h)):
            for r in range(3):
                x = field[i, n]
                h[i, r] = matrix[i, r, 0] * x[0] + matrix[i, r, 1] * x[1] + matrix[i, r, 2] * x[2] - shift[i, r]
        for r in range(3):
            g[r], g[3 + r] = h[0, r] - h[2, r], h[1, r] - h[3, r]
        one, two, mu2 = invariants_of(g[0], g[1], g[2], g[4], g[5])
        first += abs(one)
        second += abs(two) ** (2.0 / 3.0)
        third += mu2
    return first / field.shape[1], second / field.shape[1], third / field.shape[1]


@fast_kernel
def invariants_of(xx: float, xy: float, xz: float, yy: float, yz: float) -> tuple[float, float, float]:
    """I1, I2 and mu^2 of one tensor; l2 = 2 sqrt(p) cos((arccos(q / p^(3/2)) - 2 pi) / 3), p = -I1 / 3, q = I2 / 2."""
    zz = -xx - yy
    one = xx * yy + yy * zz + xx * zz - xy * xy - yz * yz - xz * xz
    two = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz)
    p = max(-one / 3.0, 1e-300)
    angle = math.acos(min(1.0, max(-1.0, 0.5 * two / (p * math.sqrt(p)))))
    middle = 2.0 * math.sqrt(p) * math.cos((angle - 2.0 * math.pi) / 3.0)
    return one, two, max(-one - 2.0 * middle * middle, 0.0)


@fast_kernel
def residuals(p: Array, task: ArrayObjective, out: Array) -> float:
    """Fill out (`residual_size`,) and return its sum of squares: J of the parameters (12 k,), in units of F^2."""
    k = task.total.shape[0]
    matrix, shift = np.empty((k, 3, 3)), np.empty((k, 3))
    fill_maps(p, matrix, shift)
    for i in range(k):
        total_residuals(task.total[i], matrix[i], shift[i], out[10 * i :])
    for e in range(task.pairs.shape[0]):
        i, j = task.pairs[e]
        pair_residuals(task.pair[e], task.weight[e], matrix[i], shift[i], matrix[j], shift[j], out[10 * k + 21 * e :])
    cost = 0.0
    for value in out:
        cost += value * value
    if task.invariant_weight > 0.0:
        one, two, three = mean_invariants(task.field, matrix, shift)
        cost += task.invariant_weight * (one + two + three)
    return cost


@fast_kernel
def array_costs(individuals: Array, task: ArrayObjective, out: Array) -> Array:
    """J (m,) of parameters (m, 12 k); out (`residual_size`,) is scratch."""
    cost = np.empty(len(individuals))
    for m in range(len(individuals)):
        cost[m] = residuals(individuals[m], task, out)
    return cost


def residual_size(task: ArrayObjective) -> int:
    """Length of the residual vector: 10 a sensor and 21 a pair."""
    return 10 * len(task.total) + 21 * len(task.pairs)


def free_parameters(k: int) -> NDArray[np.int64]:
    """Indices of the 12 k - 3 parameters that are not fixed by convention."""
    return np.delete(np.arange(PER_SENSOR * k), FIXED)


def parameter_units(k: int, strength_nT: float) -> Array:
    """Factors (12 k,) from a parameter vector to the units of SENSOR_NAMES."""
    one = np.array([strength_nT] * 3 + [1.0] * 3 + [math.degrees(1.0)] * 6)
    return np.tile(one, k)


def parameters_of(offset: Array, matrix: Array) -> Array:
    """Parameters (12,) of one sensor from h = matrix (x - offset): matrix^-1 = K C Q, Q = (T_gamma T_alpha T_beta)^-1.

    K C is the triangular factor of an RQ decomposition and has rows of length K.
    """
    flip = np.eye(3)[::-1]
    q, r = np.linalg.qr((flip @ np.linalg.inv(matrix)).T)
    kc, turn = flip @ r.T @ flip, flip @ q.T
    sign = np.sign(np.diag(kc))
    kc, turn = kc * sign, (sign[:, None] * turn)
    scale = np.linalg.norm(kc, axis=1)
    c, t = kc / scale[:, None], turn.T
    psi, phi, theta = math.atan2(c[1, 2], c[1, 1]), math.asin(c[0, 2]), math.atan2(c[0, 1], c[0, 0])
    euler = -math.asin(t[2, 1]), math.atan2(t[2, 0], t[2, 2]), math.atan2(t[0, 1], t[1, 1])
    return np.array([*offset, *scale, psi, phi, theta, *euler])


def corrected(p: Array, field: Array) -> Array:
    """Field (k, n, 3) that parameters (12 k,) make of measurements (k, n, 3), both in units of F."""
    matrix, shift = maps(p, len(field))
    return np.asarray(np.einsum("kij,knj->kni", matrix, field) - shift[:, None, :])


def tensor(field_nT: Array, baseline_m: float) -> Array:
    """Bxx, Bxy, Bxz, Byy, Byz (n, 5), nT/m, from the cross's field (4, n, 3); sensors 1, 3 on x and 2, 4 on y.

    dB/dx = (B_1 - B_3) / d,  dB/dy = (B_2 - B_4) / d  [Ding2021] eq. 1
    """
    along_x, along_y = field_nT[0] - field_nT[2], field_nT[1] - field_nT[3]
    return np.asarray(np.hstack((along_x, along_y[:, 1:])) / baseline_m)


def invariants(components: Array) -> Array:
    """I1, I2, mu (n, 3) of tensors (n, 5) with eigenvalues l1 >= l2 >= l3, [Ding2021] eq. 2, [Clark2012].

    I1 = l1 l2 + l2 l3 + l1 l3,  I2 = l1 l2 l3,  mu = sqrt(-l2^2 - l1 l3)
    """
    rows: list[Any] = [invariants_of(*row) for row in components]
    return np.array([(one, two, math.sqrt(mu2)) for one, two, mu2 in rows])

"""Directions of the field linked by the gyro: the model, its rows about an estimate, and the fit of its parameters.

x_i = G u_i + c + n_i,  u_(i+1) = exp(-[(omega_i - beta) dt_i]x) u_i + w_i,  |u_i| = 1

x measurements in units of F, omega the mean rate of a step, n and w white, w of standard deviation s_i = ratio dt_i in
units of n's. Parameters p = (c, G, beta): (3 + entries of G + 3,).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numba import njit
from numpy.typing import NDArray

from calib.numerics.chain import eliminated, states
from calib.numerics.damped import Normal

Array = NDArray[np.float64]
BIAS = 3
"""Components of the gyro's bias."""
LONG_STEP = 2.5
"""A step longer than this many medians is a gap: rates at its ends say little of the rotation between them."""
LOOSE = 1e6
"""Standard deviation, rad, of a step that the gyro says nothing of: across a gap."""
STATE_ROUNDS, STATE_SETTLED = 5, 1e-6
"""Most rounds of the directions at fixed parameters, and the share of the cost by which the last may still gain."""
LEAST_NOISE = 1e-6
"""Noise of a measurement, in units of F, that is told from none: 0.05 nT in the Earth's field."""
TINY = 1e-300
"""Keeps a direction of no length from 0 / 0."""
LEAST_TURN = 1e-6
"""Rotation of a step, rad, below which sine and cosine are their series' first terms, to rounding."""


@dataclass(frozen=True, eq=False)
class Estimate:
    """Offset c (3,), root G (3, 3), gyro's bias (3,), rad/s, and the directions u (n, 3)."""

    centre: Array
    root: Array
    bias_rad_s: Array
    directions: Array

    @classmethod
    def of(cls, x: Array, centre: Array, root: Array) -> Estimate:
        """Without bias, with the direction of each measurement (n, 3) by itself."""
        return cls(centre, root, np.zeros(BIAS), _unit(np.asarray((x - centre) @ np.linalg.inv(root).T)))


@dataclass(frozen=True, eq=False)
class Linear:
    """The least squares about an estimate, linear in the tangents of its directions and in the parameters.

    cost at the estimate; square (k + 1, k + 1) of the parameters with what is left as the last of them, the directions
    at their best; log det of the directions' information. The rest leads from parameters back to directions.
    """

    estimate: Estimate
    across: Array
    turn: Array
    B: Array
    std: Array
    cost: float
    square: Array
    logarithm: float
    A: Array
    C: Array

    def directions(self, step: Array) -> Array:
        """The best directions (n, 3) a step (k,) of the parameters further."""
        x = states(self.A, self.C, self.turn, self.B, self.std, np.append(step, 1.0))
        return _unit(self.estimate.directions + np.einsum("nij,nj->ni", self.across, x))

    @property
    def least(self) -> float:
        """The cost at the estimate's parameters with the directions at their best."""
        return max(float(self.square[-1, -1]), 0.0)


@dataclass(frozen=True, eq=False)
class Link:
    """Measurements x (n, 3), mean rates (n - 1, 3) and lengths (n - 1,), s, of the steps; 0 s for one without a gyro.

    slots (k, 3, 3): dG / d each of its parameters. ratio: the gyro's noise, rad/s, over that of x.
    """

    x: Array
    rate_rad_s: Array
    step_s: Array
    slots: Array
    ratio: float

    @property
    def count(self) -> int:
        """Number of parameters."""
        return len(self.slots) + 2 * BIAS

    @property
    def links(self) -> int:
        """Number of steps that the gyro has seen."""
        return int(np.count_nonzero(self.step_s))

    @property
    def free(self) -> int:
        """Measured values less those that fit them."""
        return len(self.x) + 2 * self.links - self.count

    def with_ratio(self, ratio: float) -> Link:
        """The same with another gyro."""
        return replace(self, ratio=ratio)

    def linear(self, e: Estimate) -> Linear:
        """The least squares about an estimate."""
        across = tangents(e.directions)
        M, J = _measured(self.x, e.directions, across, e.centre, e.root, self.slots)
        turn, B = _turned(e.directions, across, self.rate_rad_s - e.bias_rad_s, self.step_s, self.count + 1)
        std = np.where(self.step_s > 0, self.ratio * self.step_s, LOOSE)
        cost = float(np.sum(J[:, :, -1] ** 2) + np.sum((B[:, :, -1] / std[:, None]) ** 2))
        square, logarithm, A, C = eliminated(M, J, turn, B, std)
        return Linear(e, across, turn, B, std, cost, square, logarithm, A, C)

    def settled(self, e: Estimate) -> Linear:
        """The estimate with its directions at their best, and the least squares about it."""
        found = self.linear(e)
        for _ in range(STATE_ROUNDS):
            if found.least >= (1.0 - STATE_SETTLED) * found.cost:
                break
            found = self.linear(replace(e, directions=found.directions(np.zeros(self.count))))
        return found

    def normal(self, found: Linear) -> Normal:
        """Cost and normal equations of p, each direction at its best."""
        variance = max(found.least / self.free, LEAST_NOISE**2)
        return Normal(found.least, found.square[:-1, -1], found.square[:-1, :-1], variance)

    def response(self, found: Linear) -> Array:
        """How each measurement moves the parameters, to first order, directions following: (n, k, 3).

        square^-1 (J_i + M_i xi_i)^T,  xi_i (2, k) the states that follow the parameters
        """
        e = found.estimate
        M, J = _measured(self.x, e.directions, found.across, e.centre, e.root, self.slots)
        units = np.eye(self.count, self.count + 1)
        following = [states(found.A, found.C, found.turn, found.B, found.std, unit) for unit in units]
        scale = self.normal(found).scale
        rows = (J[:, :, :-1] + M @ np.stack(following, axis=2)) / scale
        inverse = np.linalg.pinv(found.square[:-1, :-1] / np.outer(scale, scale), hermitian=True)
        return np.asarray(np.einsum("jk,nik->nji", inverse / scale[:, None], rows))

    def moved(self, found: Linear, step: Array) -> Linear | None:
        """The parameters a step further and the directions that follow; None where G turns inside out."""
        e = found.estimate
        root = e.root + np.tensordot(step[3:-BIAS], self.slots, 1)
        if np.linalg.det(root) <= 0:
            return None
        return self.settled(Estimate(e.centre + step[:3], root, e.bias_rad_s + step[-BIAS:], found.directions(step)))


def _unit(u: Array) -> Array:
    return np.asarray(u / np.maximum(np.sqrt(np.einsum("ni,ni->n", u, u)), TINY)[:, None])


def steps(time_s: Array) -> Array:
    """Lengths (n - 1,), s, of the steps of times (n,); 0 where a gap is, or no time passes."""
    step = np.diff(time_s)
    return np.asarray(np.where((step > 0) & (step < LONG_STEP * np.median(step)), step, 0.0))


def tangents(u: Array) -> Array:
    """Two unit vectors across each direction (n, 3), in the columns of (n, 3, 2)."""
    least = np.eye(3)[np.argmin(np.abs(u), axis=1)]
    first = np.cross(u, least)
    first /= np.linalg.norm(first, axis=1)[:, None]
    return np.stack([first, np.cross(u, first)], axis=2)


@njit(cache=True)
def _measured(x: Array, u: Array, across: Array, centre: Array, root: Array, slots: Array) -> tuple[Array, Array]:
    """M (n, 3, 2) = G across, and J (n, 3, 3 + k + 3 + 1): I, slots u, nothing for the bias, G u + c - x."""
    n, k = len(x), len(slots)
    M, J = np.zeros((n, 3, 2)), np.zeros((n, 3, k + 7))
    for i in range(n):
        for a in range(3):
            J[i, a, a] = 1.0
            residual = centre[a] - x[i, a]
            for b in range(3):
                M[i, a, 0] += root[a, b] * across[i, b, 0]
                M[i, a, 1] += root[a, b] * across[i, b, 1]
                residual += root[a, b] * u[i, b]
                for p in range(k):
                    J[i, a, 3 + p] += slots[p, a, b] * u[i, b]
            J[i, a, k + 6] = residual
    return M, J


@njit(cache=True)
def _turned(u: Array, across: Array, rate: Array, step_s: Array, columns: int) -> tuple[Array, Array]:
    """turn (n - 1, 2, 2) = across_next^T R across, and B (n - 1, 2, columns): d / d bias, and across_next^T R u.

    R = exp(-[rate dt]x);  d (R u) / d beta = dt (R_half e_j) x R u, to second order in the step's rotation
    """
    n = len(u)
    turn, B = np.zeros((n - 1, 2, 2)), np.zeros((n - 1, 2, columns))
    R, half = np.empty((3, 3)), np.empty((3, 3))
    ahead = np.empty(3)
    for i in range(n - 1):
        _rotation(rate[i], -step_s[i], R)
        _rotation(rate[i], -0.5 * step_s[i], half)
        for a in range(3):
            ahead[a] = R[a, 0] * u[i, 0] + R[a, 1] * u[i, 1] + R[a, 2] * u[i, 2]
        for q in range(2):
            e0, e1, e2 = across[i + 1, 0, q], across[i + 1, 1, q], across[i + 1, 2, q]
            # (v x ahead) . e = (ahead x e) . v
            s0 = ahead[1] * e2 - ahead[2] * e1
            s1 = ahead[2] * e0 - ahead[0] * e2
            s2 = ahead[0] * e1 - ahead[1] * e0
            for j in range(3):
                B[i, q, columns - 4 + j] = step_s[i] * (s0 * half[0, j] + s1 * half[1, j] + s2 * half[2, j])
            B[i, q, columns - 1] = e0 * ahead[0] + e1 * ahead[1] + e2 * ahead[2] if step_s[i] > 0 else 0.0
            for b in range(2):
                for a in range(3):
                    drawn = R[a, 0] * across[i, 0, b] + R[a, 1] * across[i, 1, b] + R[a, 2] * across[i, 2, b]
                    turn[i, q, b] += across[i + 1, a, q] * drawn
    return turn, B


@njit(cache=True)
def _rotation(rate: Array, dt: float, out: Array) -> None:
    """exp([rate dt]x) (3, 3) into out."""
    a, b, c = rate[0] * dt, rate[1] * dt, rate[2] * dt
    angle = np.sqrt(a * a + b * b + c * c)
    first = np.sin(angle) / angle if angle > LEAST_TURN else 1.0
    second = (1.0 - np.cos(angle)) / angle**2 if angle > LEAST_TURN else 0.5
    out[0, 0] = 1.0 - second * (b * b + c * c)
    out[1, 1] = 1.0 - second * (a * a + c * c)
    out[2, 2] = 1.0 - second * (a * a + b * b)
    out[0, 1], out[1, 0] = -first * c + second * a * b, first * c + second * a * b
    out[0, 2], out[2, 0] = first * b + second * a * c, -first * b + second * a * c
    out[1, 2], out[2, 1] = -first * a + second * b * c, first * a + second * b * c

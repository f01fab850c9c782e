"""Directions of the field linked by the gyro: the model, its rows about an estimate, and the fit of its parameters.

x_i = G u_i + c + n_i,  u_(i+1) = exp(-[(omega_i - beta) dt_i]x) u_i + w_i,  |u_i| = 1

x measurements in units of F, omega the mean rate of a step, n and w white, w of standard deviation s_i = ratio dt_i in
units of n's. Parameters p = (c, G, beta): (3 + entries of G + 3,).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from calib.models.chained import BIAS, LOOSE, Chained, Linear, stepped
from scenarios.arrays import Array
from scenarios.kernel_cache import njit

LONG_STEP = 2.5
"""A step longer than this many medians is a gap: rates at its ends say little of the rotation between them."""
ALIKE = 0.01
"""Steps that differ by a smaller share are of one length."""
LEAST_NOISE = 1e-6
"""Noise of a measurement, in units of F, that is told from none: 0.05 nT in the Earth's field."""
TINY = 1e-300
"""Keeps a direction of no length from 0 / 0."""
LEAST_TURN = 1e-6
"""Rotation of a step, rad, below which sine and cosine are their series' first terms, to rounding."""


@dataclass(frozen=True, eq=False)
class LinkedEstimate:
    """Offset c (3,), root G (3, 3), gyro's bias (3,), rad/s, and the directions u (n, 3)."""

    centre: Array
    root: Array
    bias_rad_s: Array
    directions: Array

    @property
    def beside(self) -> Array:
        """Nothing else is found."""
        return np.zeros(0)

    @classmethod
    def of(cls, x: Array, centre: Array, root: Array) -> LinkedEstimate:
        """Without bias, with the direction of each measurement (n, 3) by itself."""
        return cls(centre, root, np.zeros(BIAS), _unit(np.asarray((x - centre) @ np.linalg.inv(root).T)))


@dataclass(frozen=True, eq=False)
class LinkedSamples(Chained[LinkedEstimate]):
    """Measurements x (n, 3), mean rates (n - 1, 3) and lengths (n - 1,), s, of the steps; 0 s for one without a gyro.

    slots (k, 3, 3): dG / d each of its parameters. ratio: the gyro's noise, rad/s, over that of x. absent: samples
    whose x is no measurement, only a start for the direction.
    """

    x: Array
    rate_rad_s: Array
    step_s: Array
    slots: Array
    ratio: float
    absent: NDArray[np.intp] = field(default_factory=lambda: np.zeros(0, np.intp))

    @property
    def count(self) -> int:
        """Number of parameters."""
        return len(self.slots) + 2 * BIAS

    @property
    def links(self) -> int:
        """Number of steps with a gyro measurement."""
        return int(np.count_nonzero(self.step_s))

    @property
    def free(self) -> int:
        """Degrees of freedom: measured values minus fitted values."""
        return len(self.x) - 3 * len(self.absent) + 2 * self.links - self.count

    def with_ratio(self, ratio: float) -> LinkedSamples:
        """The samples with a different noise ratio of the gyro."""
        return replace(self, ratio=ratio)

    @property
    def std(self) -> Array:
        """Of each step's turn, over the noise of x."""
        return np.where(self.step_s > 0, self.ratio * self.step_s, LOOSE)

    def measured(self, e: LinkedEstimate) -> tuple[Array, Array]:
        """Two coordinates across each direction; what G makes of it."""
        M, J = _measured(self.x, e.directions, tangents(e.directions), e.centre, e.root, self.slots)
        return self.seen(M, J)

    def seen(self, M: Array, J: Array) -> tuple[Array, Array]:
        """M (n, r, m) and J (n, r, k + 1), zero for absent measurements of the magnetometer, the first three rows."""
        M[self.absent, :3], J[self.absent, :3] = 0.0, 0.0
        return M, J

    def linked(self, e: LinkedEstimate) -> tuple[Array, Array]:
        """Direction to direction."""
        rate_rad_s = self.rate_rad_s - e.bias_rad_s
        turn, B = _turned(e.directions, tangents(e.directions), rate_rad_s, self.step_s, self.count + 1)
        return turn, B

    def beforehand(self, e: LinkedEstimate) -> Array:
        """Nothing."""
        return np.zeros((0, self.count + 1))

    def followed(self, e: LinkedEstimate, x: Array) -> LinkedEstimate:
        """Directions a little further across."""
        further = e.directions + np.einsum("nij,nj->ni", tangents(e.directions), x)
        return replace(e, directions=_unit(further))

    def changed(self, e: LinkedEstimate, step: Array) -> LinkedEstimate | None:
        """Offset, G and bias."""
        found = stepped(e, step, self.slots)
        return None if found is None else LinkedEstimate(*found, e.directions)

    def variance(self, found: Linear[LinkedEstimate]) -> float:
        """Residual sum of squares over degrees of freedom."""
        return max(found.least / self.free, LEAST_NOISE**2)


def _unit(u: Array) -> Array:
    return np.asarray(u / np.maximum(np.sqrt(np.einsum("ni,ni->n", u, u)), TINY)[:, None])


def steps(time_s: Array) -> Array:
    """Lengths (n - 1,), s, of the steps of times (n,); 0 where a gap is, or no time passes."""
    step = np.diff(time_s)
    return np.asarray(np.where((step > 0) & (step < LONG_STEP * np.median(step)), step, 0.0))


def mean_rates(rate_rad_s: Array, step_s: Array) -> Array:
    """Mean rate (n - 1, 3) over each step, by rates (n, 3) at its ends and, where three steps are alike, beyond them.

    (13 (omega_i + omega_(i+1)) - omega_(i-1) - omega_(i+2)) / 24,  of the cubic through the four; else that of a line.
    """
    mean = (rate_rad_s[1:] + rate_rad_s[:-1]) / 2
    before, here, after = step_s[:-2], step_s[1:-1], step_s[2:]
    alike = (here > 0) & (np.maximum(np.abs(before - here), np.abs(after - here)) < ALIKE * here)
    bend = (mean[1:-1] * 2 - rate_rad_s[:-3] - rate_rad_s[3:]) / 24
    mean[1:-1] += np.where(alike[:, None], bend, 0.0)
    return np.asarray(mean)


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
def unturned(vectors: Array, rate: Array, step_s: Array) -> Array:
    """Vectors (n, 3) in the first one's frame: Q_i v_i, Q_i the product of exp([rate dt]x) of the steps before i."""
    n = len(vectors)
    out = np.empty((n, 3))
    Q, turn, next_Q = np.eye(3), np.empty((3, 3)), np.empty((3, 3))
    for i in range(n):
        for a in range(3):
            out[i, a] = Q[a, 0] * vectors[i, 0] + Q[a, 1] * vectors[i, 1] + Q[a, 2] * vectors[i, 2]
        if i < n - 1:
            _rotation(rate[i], step_s[i], turn)
            for a in range(3):
                for b in range(3):
                    next_Q[a, b] = Q[a, 0] * turn[0, b] + Q[a, 1] * turn[1, b] + Q[a, 2] * turn[2, b]
            Q, next_Q = next_Q, Q
    return out


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

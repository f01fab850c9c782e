"""Attitudes linked by the gyro, observed by the field's direction and the accelerometer.

x_i = G Q_i h + c + n_i,  a_i = g Q_i z + e + l_i,  Q_(i+1) = exp(-[(omega_i - beta) dt_i]x + w_i) Q_i

Q (3, 3) from the world to the body, z up, h = (cos I, 0, sin I) the field's direction; x measurements in units of F, a
specific force, m/s^2, l the vehicle's accelerations with the accelerometer's noise. n, l and w white, of known standard
deviations. Parameters p = (c, G, I, g, e, beta): (3 + entries of G + 8,).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from calib.models.chained import BIAS, Chained, Linear, stepped
from calib.models.linked import LinkedEstimate as Directions
from calib.models.linked import LinkedSamples
from calib.numerics.points import cross_matrices
from scenarios.arrays import Array

BESIDE = 5
"""Parameters of the accelerometer: the field's inclination, gravity, three of bias."""
STANDARD_GRAVITY_M_S2 = 9.80665
"""From which gravity, as the accelerometer has it, is looked for."""
UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, eq=False)
class Attitudes:
    """Offset c (3,), root G (3, 3), gyro's bias (3,), rad/s, and attitudes Q (n, 3, 3).

    inclination_rad I, upwards; gravity_m_s2 g; accel_bias_m_s2 e (3,)
    """

    centre: Array
    root: Array
    bias_rad_s: Array
    Q: Array
    inclination_rad: float
    gravity_m_s2: float
    accel_bias_m_s2: Array

    @classmethod
    def of(cls, known: Directions, accel_m_s2: Array) -> Attitudes:
        """From directions (n, 3) of the field and the specific force (n, 3), taken for up. [Black1964]

        Both directions and their normal, in the body and in the world, give an attitude each.
        """
        up = accel_m_s2 / np.linalg.norm(accel_m_s2, axis=1)[:, None]
        inclination = float(np.arcsin(np.clip(np.mean(np.einsum("ni,ni->n", known.directions, up)), -1.0, 1.0)))
        body, world = _triad(known.directions, up), _triad(_field(inclination)[None], UP[None])
        Q = np.asarray(body @ world[0].T)
        return cls(known.centre, known.root, known.bias_rad_s, Q, inclination, STANDARD_GRAVITY_M_S2, np.zeros(3))

    @property
    def beside(self) -> Array:
        """Inclination, gravity and the accelerometer's bias."""
        return np.array([self.inclination_rad, self.gravity_m_s2, *self.accel_bias_m_s2])

    @property
    def up(self) -> Array:
        """Up (n, 3) in the body."""
        return self.Q[:, :, 2]

    @property
    def directions(self) -> Array:
        """The field's direction (n, 3) in the body."""
        return np.asarray(self.Q @ _field(self.inclination_rad))

    def forces(self) -> Array:
        """Specific force at rest (n, 3), m/s^2."""
        return np.asarray(self.gravity_m_s2 * self.up + self.accel_bias_m_s2)


@dataclass(frozen=True, eq=False)
class Levelled(Chained[Attitudes]):
    """A link with the specific force a (n, 3), m/s^2; noise : of x; level_m_s2 : of a, each axis.

    gravity_std_m_s2 : uncertainty of gravity, by the accelerometer's scale; inclination_rad : the field's inclination
    and its uncertainty, None where unknown.
    """

    link: LinkedSamples
    accel_m_s2: Array
    noise: float
    level_m_s2: float
    gravity_std_m_s2: float
    inclination_rad: tuple[float, float] | None = None

    @property
    def count(self) -> int:
        """Number of parameters."""
        return self.link.count + BESIDE

    @property
    def std(self) -> Array:
        """Of each step's turn, over the noise of x."""
        return self.link.std

    def with_level(self, level_m_s2: float) -> Levelled:
        """The same with another accelerometer."""
        return replace(self, level_m_s2=level_m_s2)

    def measured(self, e: Attitudes) -> tuple[Array, Array]:
        """Rotations of the body, and field and force that follow them."""
        u, slots = e.directions, self.link.slots
        n, first = len(u), 3 + len(slots)
        M, J = np.empty((n, 6, 3)), np.zeros((n, 6, self.count + 1))
        M[:, :3] = -e.root @ cross_matrices(u)
        J[:, :3, :3] = np.eye(3)
        J[:, :3, 3:first] = np.einsum("pij,nj->nip", slots, u)
        J[:, :3, first] = e.Q @ _field(e.inclination_rad + np.pi / 2) @ e.root.T
        J[:, :3, -1] = u @ e.root.T + e.centre - self.link.x
        over = self.noise / self.level_m_s2
        M[:, 3:] = -over * e.gravity_m_s2 * cross_matrices(e.up)
        J[:, 3:, first + 1] = over * e.up
        J[:, 3:, first + 2 : first + BESIDE] = over * np.eye(3)
        J[:, 3:, -1] = over * (e.forces() - self.accel_m_s2)
        return self.link.seen(M, J)

    def linked(self, e: Attitudes) -> tuple[Array, Array]:
        """Attitude to attitude: d / d bias = dt R_half, to second order in the step's rotation."""
        step_s = self.link.step_s[:, None]
        turned = (self.link.rate_rad_s - e.bias_rad_s) * step_s
        R, half = (Rotation.from_rotvec(-share * turned).as_matrix() for share in (1.0, 0.5))
        B = np.zeros((len(R), 3, self.count + 1))
        B[:, :, -1 - BIAS : -1] = step_s[:, :, None] * half
        apart = Rotation.from_matrix(R @ e.Q[:-1] @ e.Q[1:].transpose(0, 2, 1)).as_rotvec()
        B[:, :, -1] = np.where(step_s > 0, apart, 0.0)
        return R, B

    def beforehand(self, e: Attitudes) -> Array:
        """Gravity, and inclination where it is known."""
        first = 3 + len(self.link.slots)
        rows = np.zeros((2, self.count + 1))
        rows[0, first + 1], rows[0, -1] = 1.0, e.gravity_m_s2 - STANDARD_GRAVITY_M_S2
        rows[0] *= self.noise / self.gravity_std_m_s2
        if self.inclination_rad is not None:
            known, std = self.inclination_rad
            rows[1, first], rows[1, -1] = 1.0, e.inclination_rad - known
            rows[1] *= self.noise / std
        return rows

    def followed(self, e: Attitudes, x: Array) -> Attitudes:
        """Attitudes turned by x (n, 3), rad, about the body's axes."""
        return replace(e, Q=Rotation.from_rotvec(x).as_matrix() @ e.Q)

    def changed(self, e: Attitudes, step: Array) -> Attitudes | None:
        """Offset, G and bias; inclination, gravity, and the accelerometer's bias."""
        found = stepped(e, step, self.link.slots)
        if found is None:
            return None
        inclination, gravity, *bias = step[-BIAS - BESIDE : -BIAS]
        more = (e.inclination_rad + inclination, e.gravity_m_s2 + gravity, e.accel_bias_m_s2 + np.array(bias))
        return Attitudes(*found, e.Q, *more)

    def variance(self, found: Linear[Attitudes]) -> float:
        """Known."""
        return self.noise**2


def _field(inclination_rad: float) -> Array:
    return np.array([np.cos(inclination_rad), 0.0, np.sin(inclination_rad)])


def _triad(u: Array, up: Array) -> Array:
    """Orthonormal axes (n, 3, 3), in columns: u, across u and up, and their normal."""
    across = np.cross(u, up)
    across /= np.linalg.norm(across, axis=1)[:, None]
    return np.stack([u, across, np.cross(u, across)], axis=2)

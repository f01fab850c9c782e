"""The 6-DOF equations of a submerged body, coded independently of the engine: added mass, drag, lift, weights."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import mujoco
import numpy as np
from scipy.integrate import quad
from scipy.spatial.transform import Rotation

from scenarios.arrays import Array

DENSITY, GRAVITY = 1025.0, 9.81
UP = np.array([0.0, 0.0, 1.0])


def tuckerman(size: Array) -> tuple[Array, Array]:
    """Virtual mass (3) and inertia (3) of an ellipsoid per density, by quadrature of [Tuckerman1925]."""
    a = np.asarray(size)

    def kappa(i: int) -> float:
        root = lambda s: np.prod(a) * 2 / (a[i] ** 2 + s * s) * s / np.sqrt(np.prod(a**2 + s * s))  # noqa: E731
        return float(quad(root, 0, np.inf, epsabs=1e-13, epsrel=1e-11, limit=500)[0])

    k, volume = np.array([kappa(i) for i in range(3)]), 4 / 3 * np.pi * np.prod(a)
    inertia = np.zeros(3)
    for i in range(3):
        p, q = a[(i + 1) % 3] ** 2, a[(i + 2) % 3] ** 2
        kp, kq = k[(i + 1) % 3], k[(i + 2) % 3]
        if p != q:
            inertia[i] = volume / 5 * (p - q) ** 2 * (kq - kp) / (2 * (p - q) + (p + q) * (kp - kq))
    return volume * k / (2 - k), inertia


def drag_and_lift(v: Array, w: Array, size: Array, coefficients: Array, viscosity: float) -> tuple[Array, Array]:
    """Force and torque on an ellipsoid, by the formulas of the engine's manual (its projected area included)."""
    blunt, slender, angular, kutta, magnus = coefficients
    speed, (rx, ry, rz), order = np.linalg.norm(v), size, np.sort(size)
    normal = np.array([ry * rz / rx, rz * rx / ry, rx * ry / rz]) * v
    largest = np.pi * order[2] * order[1]
    area = np.pi * np.sqrt(
        ((ry * rz) ** 4 * v[0] ** 2 + (rz * rx) ** 4 * v[1] ** 2 + (rx * ry) ** 4 * v[2] ** 2)
        / ((ry * rz * v[0]) ** 2 + (rz * rx * v[1]) ** 2 + (rx * ry * v[2]) ** 2 + 1e-300)
    )
    n = normal / (np.linalg.norm(normal) + 1e-300)
    force = -DENSITY * (blunt * area + slender * (largest - area)) * speed * v
    force += magnus * DENSITY * 4 / 3 * np.pi * np.prod(size) * np.cross(w, v)
    force += kutta * DENSITY * area * (v @ n) / (speed + 1e-300) * np.cross(np.cross(n, v), v)
    swept = 8 * np.pi / 15 * np.array([size[i] * max(size[i - 1], size[i - 2]) ** 4 for i in range(3)])
    torque = -DENSITY * np.linalg.norm((angular * swept + slender * (swept.max() - swept)) * w) * w
    mean = np.mean(size)
    return force - 6 * np.pi * mean * viscosity * v, torque - 8 * np.pi * mean**3 * viscosity * w


@dataclass
class Fossen:
    """The 6-DOF equations about the hull's centre, in a steady current c ([Fossen2011] chapters 6 to 8):

    M_RB nu' + C_RB(nu) nu + M_A nu_r' + C_A(nu_r) nu_r + d(nu_r) + g = tau,   nu_r = nu - [R^T c, 0].
    """

    model: mujoco.MjModel
    tau: Array = field(default_factory=lambda: np.zeros(6))
    ballast_N: float = 0.0
    trim_m: float = 0.0
    current: Array = field(default_factory=lambda: np.zeros(3))
    parts: list[tuple[Array, Array, Array, Array]] = field(init=False)

    def __post_init__(self) -> None:
        m = self.model
        wet = [g for g in range(m.ngeom) if m.geom_fluid[g, 0]]
        self.parts = [(m.geom_pos[g], m.geom_size[g], m.geom_fluid[g, 1:6], m.geom_fluid[g, 6:12]) for g in wet]
        self.rigid, self.added = self.from_energy(self.body_energy), self.from_energy(self.water_energy)
        self.total = self.rigid + self.added

    def body_energy(self, nu: Array) -> float:
        hull = self.model.body("auv")
        v = nu[:3] + np.cross(nu[3:], hull.ipos)
        speck = self.model.body("buoyancy")
        return float(hull.mass[0] * v @ v + hull.inertia @ nu[3:] ** 2 + speck.mass[0] * nu[:3] @ nu[:3]) / 2

    def water_energy(self, nu: Array) -> float:
        energy = 0.0
        for where, _, _, virtual in self.parts:
            v = nu[:3] + np.cross(nu[3:], where)
            energy += DENSITY / 2 * (virtual[:3] @ v**2 + virtual[3:] @ nu[3:] ** 2)
        return float(energy)

    @staticmethod
    def from_energy(energy: Any) -> Array:
        """M of T = nu^T M nu / 2 by polarisation."""
        e = np.eye(6)
        return np.array([[energy(a + b) - energy(a) - energy(b) for b in e] for a in e])

    @staticmethod
    def coriolis(mass: Array, nu: Array) -> Array:
        p, q = (mass @ nu)[:3], (mass @ nu)[3:]
        return np.concatenate([np.cross(nu[3:], p), np.cross(nu[3:], q) + np.cross(nu[:3], p)])

    def viscous(self, nu_r: Array) -> Array:
        total = np.zeros(6)
        for where, size, coefficients, _ in self.parts:
            flow, viscosity = nu_r[:3] + np.cross(nu_r[3:], where), self.model.opt.viscosity
            force, torque = drag_and_lift(flow, nu_r[3:], size, coefficients, viscosity)
            total += np.concatenate([force, torque + np.cross(where, force)])
        return total

    def weights(self, up: Array) -> Array:
        """Weight, equal buoyancy at the origin, and the ballast ahead of the centre of mass."""
        centre = self.model.body("auv").ipos
        weight = self.model.body("auv").mass[0] * GRAVITY
        sunk = -self.ballast_N * up
        return np.concatenate(
            [sunk, np.cross(centre, -weight * up) + np.cross(centre + self.trim_m * np.eye(3)[0], sunk)]
        )

    def acceleration(self, nu: Array, R: Array) -> Array:
        stream = np.concatenate([R.T @ self.current, np.zeros(3)])
        nu_r, carried = nu - stream, np.concatenate([-np.cross(nu[3:], stream[:3]), np.zeros(3)])
        known = self.tau + self.weights(R.T @ UP) + self.viscous(nu_r) + self.added @ carried
        known = known - self.coriolis(self.rigid, nu) - self.coriolis(self.added, nu_r)
        return np.linalg.solve(self.total, known)

    def slope(self, _: float, y: Array) -> Array:
        q, nu = y[3:7] / np.linalg.norm(y[3:7]), y[7:]
        R = Rotation.from_quat(q, scalar_first=True).as_matrix()
        w = nu[3:]
        dq = 0.5 * np.concatenate([[-w @ q[1:]], q[0] * w + np.cross(q[1:], w)])
        return np.concatenate([R @ nu[:3], dq, self.acceleration(nu, R)])

"""Axes and sensitivities of the sensor: turned, not square to each other, not equal."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sim.effects.base import ZERO3, Effect, Memory, Vec3, array, choice, parameter
from sim.effects.kernels import times
from sim.effects.rotation import rotation, triangular, zhang_installation
from sim.state import Array, State


@dataclass(frozen=True)
class Misalignment(Effect):
    """Turn of the whole sensor against the body: ``(R - I) s``, R = Rz Ry Rx.

    Form "zhang2018": the symmetric small-angle matrix of [Zhang2018] eq. 2 in R's place, which is no rotation.
    """

    name: ClassVar[str] = "misalignment"
    stage: ClassVar[str] = "sensor"
    static: ClassVar[bool] = True
    tangents: ClassVar[dict[str, tuple[Vec3, ...]]] = {"angles_deg": ((0.01, 0, 0), (0, 0.01, 0), (0, 0, 0.01))}

    angles_deg: Vec3 = parameter(ZERO3, "deg", -180.0, 180.0, "about forward, left, up")
    form: str = choice("rotation", ("rotation", "zhang2018"), "rotation, or the matrix of Zhang2018 eq. 2")

    def matrix(self) -> Array:
        """R (3, 3)."""
        return rotation(self.angles_deg) if self.form == "rotation" else zhang_installation(self.angles_deg)

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        return times(self.matrix() - np.eye(3), signal_nT)


@dataclass(frozen=True)
class NonOrthogonality(Effect):
    """Axes that are not square to each other: ``(N - I) s``, N upper-triangular with rows of length one.

    ``N = [[cos xz cos xy, sin xy, sin xz cos xy], [0, cos yz, sin yz], [0, 0, 1]]``: [Zhang2018] eq. 3 with
    xy = gamma, xz = alpha, yz = beta. With a rotation before it, any three axes.
    """

    name: ClassVar[str] = "non_orthogonality"
    stage: ClassVar[str] = "sensor"
    static: ClassVar[bool] = True
    tangents: ClassVar[dict[str, tuple[Vec3, ...]]] = {"angles_deg": ((0.01, 0, 0), (0, 0.01, 0), (0, 0, 0.01))}

    angles_deg: Vec3 = parameter(ZERO3, "deg", -60.0, 60.0, "xy, xz, yz: how far an axis leans to another")

    def matrix(self) -> Array:
        """N (3, 3)."""
        return triangular(self.angles_deg)

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        return times(self.matrix() - np.eye(3), signal_nT)


@dataclass(frozen=True)
class Scale(Effect):
    """Sensitivities that differ from one: ``diag(e) s``, so factors 1 + e ([Zhang2018] C_SF, [Long2013] C_k)."""

    name: ClassVar[str] = "scale"
    stage: ClassVar[str] = "sensor"
    static: ClassVar[bool] = True
    linear: ClassVar[tuple[str, ...]] = ("error",)

    error: Vec3 = parameter(ZERO3, "", -0.99, 10.0, "e of the axes x, y, z", per_axis=True)

    def matrix(self) -> Array:
        """diag(1 + e) (3, 3)."""
        return np.diag(1.0 + array(self.error))

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        return signal_nT * array(self.error)

"""Axes and sensitivities of the sensor: rotation, non-orthogonality, scale."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np

from scenarios.arrays import Array
from sim.effects.base import ZERO3, Effect, Memory, array, frozen
from sim.effects.kernels import times
from sim.effects.parameters import OneOf, Quantity, Vec3
from sim.effects.rotation import rotation, triangular, zhang_installation
from sim.effects.traits import IN_ITS_MOUNT, Traits
from sim.state import State


@frozen
class Misalignment(Effect):
    """Turn of the whole sensor against the body: ``(R - I) s``, R = Rz Ry Rx.

    Form "zhang2018": the symmetric small-angle matrix of [Zhang2018] eq. 2 in place of the rotation R.
    """

    name = "misalignment"
    stage = "sensor"
    static = True
    example = {"angles_deg": (1.0, -2.0, 3.0)}
    traits = Traits(
        experiment=IN_ITS_MOUNT, remedy="calibrate with attitude, against the field's vector", absorbed=True
    )

    angles_deg: Annotated[Vec3, Quantity("deg", -180.0, 180.0, "about forward, left, up", role="tangent")] = ZERO3
    form: Annotated[Literal["rotation", "zhang2018"], OneOf("rotation, or the matrix of Zhang2018 eq. 2")] = "rotation"

    def matrix(self) -> Array:
        """R (3, 3)."""
        return rotation(self.angles_deg) if self.form == "rotation" else zhang_installation(self.angles_deg)

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        return times(self.matrix() - np.eye(3), signal_nT)


@frozen
class NonOrthogonality(Effect):
    """Non-orthogonal axes: ``(N - I) s``, N upper-triangular with unit rows.

    ``N = [[cos xz cos xy, sin xy, sin xz cos xy], [0, cos yz, sin yz], [0, 0, 1]]``: [Zhang2018] eq. 3 with
    xy = gamma, xz = alpha, yz = beta. Behind a rotation, N describes any three axes.
    """

    name = "non_orthogonality"
    stage = "sensor"
    static = True
    example = {"angles_deg": (1.0, -0.5, 0.7)}
    traits = Traits(
        experiment=IN_ITS_MOUNT,
        remedy="calibrate the sensor's axes, on a turntable or in motion over the whole sphere",
        absorbed=True,
    )

    angles_deg: Annotated[
        Vec3, Quantity("deg", -60.0, 60.0, "xy, xz, yz: how far an axis leans to another", role="tangent")
    ] = ZERO3

    def matrix(self) -> Array:
        """N (3, 3)."""
        return triangular(self.angles_deg)

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        return times(self.matrix() - np.eye(3), signal_nT)


@frozen
class Scale(Effect):
    """Sensitivities other than 1: ``diag(e) s``, factors 1 + e ([Zhang2018] C_SF, [Long2013] C_k)."""

    name = "scale"
    stage = "sensor"
    static = True
    example = {"error": (0.1, -0.05, 0.02)}
    traits = Traits(
        experiment=IN_ITS_MOUNT,
        remedy="calibrate the sensor's axes, on a turntable or in motion over the whole sphere",
        absorbed=True,
    )

    error: Annotated[Vec3, Quantity("", -0.99, 10.0, "e of the axes x, y, z", role="linear", per_axis=True)] = ZERO3

    def matrix(self) -> Array:
        """diag(1 + e) (3, 3)."""
        return np.diag(1.0 + array(self.error))

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        return signal_nT * array(self.error)

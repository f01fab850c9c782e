"""The Earth's field as it is not: changing in the day, uneven in space, seen through a turned navigation frame."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sim.effects.base import ZERO3, ZERO33, Effect, Mat3, Memory, Vec3, array, parameter
from sim.effects.kernels import turn_to_body
from sim.effects.rotation import rotation
from sim.state import Array, State


@dataclass(frozen=True)
class DiurnalDrift(Effect):
    """Slow change of the Earth's field in the day, zero at the start of the run.

    ``R_wb^T a (sin(2 pi t / P + phi) - sin(phi))``, a in east, north, up.
    """

    name: ClassVar[str] = "diurnal_drift"
    stage: ClassVar[str] = "field"
    needs: ClassVar[tuple[str, ...]] = ("attitude",)
    linear: ClassVar[tuple[str, ...]] = ("amplitude_enu_nT",)

    amplitude_enu_nT: Vec3 = parameter(ZERO3, "nT", -5e3, 5e3, "amplitude a east, north, up")
    period_s: float = parameter(86_400.0, "s", 1.0, 1e7, "period P")
    phase_deg: float = parameter(0.0, "deg", -360.0, 360.0, "phase phi at the start of the run")

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        phase = math.radians(self.phase_deg)
        course = np.sin((2 * math.pi / self.period_s) * state.time_s + phase) - math.sin(phase)
        return turn_to_body(state.R_wb, course[:, None] * array(self.amplitude_enu_nT))


@dataclass(frozen=True)
class FieldGradient(Effect):
    """Uniform gradient of the field: ``R_wb^T G (p - origin)``.

    G symmetric (no currents) and trace-free (no monopoles): the five free components are xx, yy, xy, xz, yz in
    east, north, up. [Li2017] names the uneven field (below 5 nT/m) as an error that its model leaves out.
    """

    name: ClassVar[str] = "field_gradient"
    stage: ClassVar[str] = "field"
    needs: ClassVar[tuple[str, ...]] = ("attitude", "position")
    linear: ClassVar[tuple[str, ...]] = ("gradient_nT_m",)
    units: ClassVar[dict[str, tuple[Mat3, ...]]] = {
        "gradient_nT_m": (
            ((1, 0, 0), (0, 0, 0), (0, 0, -1)),
            ((0, 0, 0), (0, 1, 0), (0, 0, -1)),
            ((0, 1, 0), (1, 0, 0), (0, 0, 0)),
            ((0, 0, 1), (0, 0, 0), (1, 0, 0)),
            ((0, 0, 0), (0, 0, 1), (0, 1, 0)),
        )
    }

    gradient_nT_m: Mat3 = parameter(ZERO33, "nT/m", -1e4, 1e4, "gradient G, symmetric and trace-free, east north up")
    origin_enu_m: Vec3 = parameter(ZERO3, "m", -1e7, 1e7, "where it contributes nothing")

    def problem(self) -> str | None:
        """A matrix that no static source outside can make."""
        gradient = array(self.gradient_nT_m)
        slack = 1e-6 * np.abs(gradient).max()
        if np.abs(gradient - gradient.T).max() > slack:
            return "gradient_nT_m must be symmetric: the field has no sources at the vehicle"
        if abs(np.trace(gradient)) > slack:
            return f"gradient_nT_m must have a zero sum on its diagonal, found {np.trace(gradient):g} nT/m"
        return None

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        way = state.pos_enu_m - array(self.origin_enu_m)
        return turn_to_body(state.R_wb, way @ array(self.gradient_nT_m))


@dataclass(frozen=True)
class AttitudeMisalignment(Effect):
    """Fixed turn of navigation's attitude on the world side, the inertial system's initial alignment error.

    ``R_nav = R_delta R_wb``, R_delta = Rz Ry Rx. The magnetometer does not feel it: its contribution to a simulated
    signal is zero, and the simulator turns navigation's attitude by `turn`. On a recording, where R_wb is not
    known, it corrects a model built on R_nav: ``R_wb^T F = R_nav^T F + R_nav^T (R_delta - I) F``.
    [Li2017] names it as an error that its model leaves out.
    """

    name: ClassVar[str] = "attitude_misalignment"
    stage: ClassVar[str] = "field"
    needs: ClassVar[tuple[str, ...]] = ("attitude",)
    tangents: ClassVar[dict[str, tuple[Vec3, ...]]] = {"angles_deg": ((0.01, 0, 0), (0, 0.01, 0), (0, 0, 0.01))}

    angles_deg: Vec3 = parameter(ZERO3, "deg", -180.0, 180.0, "turn about east, north, up")

    def turn(self, R_wb: Array) -> Array:
        """Navigation's attitude R_nav (n, 3, 3) for the true R_wb (n, 3, 3)."""
        turned: Array = rotation(self.angles_deg) @ R_wb
        return turned

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        if state.attitude == "truth":
            return np.zeros((len(state), 3))
        change = (rotation(self.angles_deg) - np.eye(3)) @ state.field_enu_nT
        return turn_to_body(state.R_wb, change[None, :])

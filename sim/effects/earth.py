"""Errors of the Earth's field: a constant, a change in time, a gradient, a turned navigation frame."""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np

from scenarios.arrays import Array
from sim.effects.base import ZERO3, ZERO33, Effect, Memory, array, frozen
from sim.effects.kernels import times
from sim.effects.parameters import Mat3, Quantity, Vec3
from sim.effects.rotation import rotation
from sim.effects.traits import ANOTHER_INSTRUMENT, THE_TRACK_AGAIN, Traits
from sim.portable_arithmetic import product
from sim.rotation import to_body
from sim.state import State

UNIT_GRADIENTS: tuple[Mat3, ...] = (
    ((1, 0, 0), (0, 0, 0), (0, 0, -1)),
    ((0, 0, 0), (0, 1, 0), (0, 0, -1)),
    ((0, 1, 0), (1, 0, 0), (0, 0, 0)),
    ((0, 0, 1), (0, 0, 0), (1, 0, 0)),
    ((0, 0, 0), (0, 0, 1), (0, 1, 0)),
)
"""The free components of a gradient, symmetric and trace-free: xx, yy, xy, xz, yz."""


@frozen
class RegionalField(Effect):
    """Constant error of the given earth field: ``R_wb^T c``, c in east, north, up.

    The difference between true and given field: the crust's field (some hundred nT), a different date or place. Where
    hard and soft iron are fitted too, the part of c along the field acts as a scale of the soft iron, and the part
    across the field acts as a turn, like `attitude_misalignment`.
    """

    name = "regional_field"
    stage = "field"
    needs = ("attitude",)
    example = {"error_enu_nT": (150.0, -80.0, 60.0)}
    traits = Traits(
        experiment=ANOTHER_INSTRUMENT,
        remedy="give the field as it was measured at the place, or calibrate against its strength alone",
    )

    error_enu_nT: Annotated[
        Vec3, Quantity("nT", -5e3, 5e3, "true field less the given one, east, north, up", role="linear")
    ] = ZERO3

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        return np.asarray(to_body(state.R_wb, array(self.error_enu_nT)[None, :]))


@frozen
class DiurnalDrift(Effect):
    """Slow change of the Earth's field in the day, zero at the start of the run.

    ``R_wb^T a (sin(2 pi t / P + phi) - sin(phi))``, a in east, north, up.
    """

    name = "diurnal_drift"
    stage = "field"
    needs = ("attitude",)
    example = {
        "amplitude_enu_nT": (10.0, -20.0, 30.0),
        "period_s": 300.0,
        "phase_deg": 40.0,
    }
    traits = Traits(
        experiment="log a base station beside the run",
        remedy="take off the record of a base station or an observatory",
        whole_run=True,
        field_source=True,
        max_rate_nT_s=5.0,  # geomagnetic storms reach it for minutes
    )

    amplitude_enu_nT: Annotated[Vec3, Quantity("nT", -5e3, 5e3, "amplitude a east, north, up", role="linear")] = ZERO3
    period_s: Annotated[float, Quantity("s", 1.0, 1e7, "period P", role="period")] = 86_400.0
    phase_deg: Annotated[float, Quantity("deg", -360.0, 360.0, "phase phi at the start of the run", role="phase")] = 0.0

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        phase = math.radians(self.phase_deg)
        course = np.sin((2 * math.pi / self.period_s) * state.time_s + phase) - math.sin(phase)
        return np.asarray(to_body(state.R_wb, course[:, None] * array(self.amplitude_enu_nT)))

    def convention_columns(self, state: State, signal_nT: Array) -> Array:
        """Constant field in the world: a different time of the day as reference."""
        return np.asarray(state.R_wb.transpose(0, 2, 1))


@frozen
class FieldGradient(Effect):
    """Uniform gradient of the field: ``R_wb^T G (p - origin)``.

    G symmetric (no currents) and trace-free (no monopoles): the five free components are xx, yy, xy, xz, yz in
    east, north, up. [Li2017] names the uneven field (below 5 nT/m) as an error outside the model.
    """

    name = "field_gradient"
    stage = "field"
    needs = ("attitude", "position")
    example = {"gradient_nT_m": ((1.0, 2.0, 3.0), (2.0, 1.0, 4.0), (3.0, 4.0, -2.0)), "origin_enu_m": (5.0, 6.0, 7.0)}
    traits = Traits(
        experiment=THE_TRACK_AGAIN,
        remedy="calibrate at a place with an even field",
        field_source=True,
        contains=(RegionalField.name, "attitude_misalignment"),
    )

    gradient_nT_m: Annotated[
        Mat3,
        Quantity(
            "nT/m",
            -1e4,
            1e4,
            "gradient G, symmetric and trace-free, east north up",
            role="linear",
            units=UNIT_GRADIENTS,
        ),
    ] = ZERO33
    origin_enu_m: Annotated[Vec3, Quantity("m", -1e7, 1e7, "where it contributes nothing", role="origin")] = ZERO3

    def problem(self) -> str | None:
        """Asymmetry or trace of G, which no static source outside the vehicle can make."""
        gradient = array(self.gradient_nT_m)
        slack = 1e-6 * np.abs(gradient).max()
        if np.abs(gradient - gradient.T).max() > slack:
            return "gradient_nT_m must be symmetric: the field has no sources at the vehicle"
        if abs(np.trace(gradient)) > slack:
            return f"gradient_nT_m must have a zero sum on its diagonal, found {np.trace(gradient):g} nT/m"
        return None

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        way = state.pos_enu_m - array(self.origin_enu_m)
        return np.asarray(to_body(state.R_wb, times(array(self.gradient_nT_m), way)))


@frozen
class AttitudeMisalignment(Effect):
    """Fixed turn of navigation's attitude on the world side, the inertial system's initial alignment error.

    ``R_nav = R_delta R_wb``, R_delta = Rz Ry Rx. The magnetometer does not sense the turn: the contribution to a
    simulated signal is zero, and the simulator turns navigation's attitude by `turn`. On a recording, where R_wb is not
    known, the effect corrects a model built on R_nav: ``R_wb^T F = R_nav^T F + R_nav^T (R_delta - I) F``.
    [Li2017] names the misalignment as an error outside the model.
    """

    name = "attitude_misalignment"
    stage = "field"
    needs = ("attitude",)
    example = {"angles_deg": (0.5, -1.0, 2.0)}
    traits = Traits(
        experiment=ANOTHER_INSTRUMENT,
        remedy="align the navigation anew, or calibrate against the field's strength alone",
        equivalent_to=RegionalField.name,
        whole_run=True,
        attitude_error=True,
    )

    angles_deg: Annotated[Vec3, Quantity("deg", -180.0, 180.0, "turn about east, north, up", role="tangent")] = ZERO3

    def turn(self, R_wb: Array) -> Array:
        """Navigation's attitude R_nav (n, 3, 3) for the true R_wb (n, 3, 3)."""
        return product(rotation(self.angles_deg), R_wb)

    def apply(self, state: State, signal_nT: Array, rng: np.random.Generator, memory: Memory) -> Array:
        if state.attitude == "truth":
            return np.zeros((len(state), 3))
        change = (rotation(self.angles_deg) - np.eye(3)) @ state.field_enu_nT
        return np.asarray(to_body(state.R_wb, change[None, :]))

"""Trials of [Ding2021]'s simulations: an array of four sensors simulated and calibrated, a seed per task."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from calib import Calibration, Reference
from calib.families.gradiometer import ArrayEstimate, GradiometerCalibrator
from calib.methods.ide_gradiometer import IdeGradiometer
from calib.methods.least_squares_gradiometer import LeastSquaresGradiometer
from calib.methods.two_step_gradiometer import TwoStepGradiometer
from calib.models.sensor_array import (
    ArrayObjective,
    array_objective,
    corrected,
    free_parameters,
    maps,
    parameter_units,
    tensor,
)
from papers.attitudes import state_at_attitudes
from recordings import Recording
from scenarios.arrays import Array
from scenarios.seeds import stream
from sim.chain import apply_deterministic
from sim.effects.papers import ding2021
from sim.state import State

STRENGTH_NT, DECLINATION_DEG, INCLINATION_DEG, BASELINE_M = 52_000.0, -7.0, 54.0, 0.4
REFERENCE = Reference(STRENGTH_NT)
SENSORS = 4
OFFSETS = (0, 1, 2)
"""Indices of a sensor's offset among its parameters."""
OFFSET, SCALE, AXES, TURN = (slice(0, 3), slice(3, 6), slice(6, 9), slice(9, 12))


@dataclass(frozen=True)
class ErrorWidths:
    """Half widths of the uniform distributions of a simulation's errors."""

    offset_nT: float
    scale: float
    axes_deg: float
    turn_deg: float


CASES = {1: ErrorWidths(200.0, 0.1, 2.0, 2.0), 2: ErrorWidths(100.0, 1e-4, 0.1, 1.0)}


@dataclass(frozen=True, eq=False)
class SensorErrors:
    """Errors of a sensor of the array: offset_nT, scale, axes_deg (psi, phi, theta), turn_deg, (3,) each."""

    offset_nT: Array
    scale: Array
    axes_deg: Array
    turn_deg: Array

    @classmethod
    def drawn(cls, case: ErrorWidths, draw: np.random.Generator, *, first: bool) -> SensorErrors:
        """Draw errors uniform within the half widths; the first sensor is the reference, without misalignment."""
        return cls(
            draw.uniform(-1, 1, 3) * case.offset_nT,
            1 + draw.uniform(-1, 1, 3) * case.scale,
            draw.uniform(-1, 1, 3) * case.axes_deg,
            draw.uniform(-1, 1, 3) * case.turn_deg * (not first),
        )

    def measured_nT(self, state: State) -> Array:
        """Return the measured field without noise, (n, 3)."""
        psi, phi, theta = self.axes_deg
        effects = ding2021(_three(self.offset_nT), _three(self.scale), psi, phi, theta, _three(self.turn_deg))
        return np.asarray(state.field_nT + sum(apply_deterministic(effects, state)[1].values()))

    def parameters(self) -> Array:
        """Return the twelve parameters as in `calib.models.sensor_array`: offset over field, scale, angles in rad."""
        angles = np.radians([*self.axes_deg, *self.turn_deg])
        return np.concatenate((self.offset_nT / STRENGTH_NT, self.scale, angles))


@dataclass(frozen=True, eq=False)
class Array4:
    """A simulated array: recording, measured field without noise (4, n, 3) in nT, true parameters (48,)."""

    recording: Recording
    clean_nT: Array
    parameters: Array


def field_enu_nT() -> Array:
    """Return the paper's field, east, north, up: 52,000 nT, declination -7, inclination 54 degrees."""
    d, i = np.radians(DECLINATION_DEG), np.radians(INCLINATION_DEG)
    return STRENGTH_NT * np.array([np.cos(i) * np.sin(d), np.cos(i) * np.cos(d), -np.sin(i)])


def simulate(
    case: int, noise_nT: float, seed: int, n: int = 200, common: bool = False, R_wb: Array | None = None
) -> Array4:
    """Simulate n random attitudes with noise uniform within +-noise_nT on each axis; `common`: equal on all sensors.

    R_wb (n, 3, 3): other attitudes, with the errors and the noise of the random ones.
    """
    draw = stream(2021, seed, case, n)
    drawn = Rotation.random(n, rng=draw).as_matrix()
    state = state_at_attitudes(drawn if R_wb is None else R_wb, field_enu_nT())
    sensors = [SensorErrors.drawn(CASES[case], draw, first=i == 0) for i in range(SENSORS)]
    clean_nT = np.array([sensor.measured_nT(state) for sensor in sensors])
    noise = stream(2021, seed, case, n, "noise").uniform(-1.0, 1.0, (SENSORS, n, 3))
    array_nT = clean_nT + noise_nT * (noise[:1] if common else noise)
    recording = Recording(np.arange(n, dtype=float), array_nT[0], array_mag_nT=array_nT)
    return Array4(recording, clean_nT, np.concatenate([sensor.parameters() for sensor in sensors]))


def _three(values: Array) -> tuple[float, float, float]:
    x, y, z = (float(v) for v in values)
    return x, y, z


def vector_of(fit: Calibration) -> Array:
    """Return a calibration's parameter vector (48,) in the order and units of `calib.models.sensor_array`."""
    values = np.array(list(fit.parameters.values())[: 12 * SENSORS])
    return np.asarray(values / parameter_units(SENSORS, STRENGTH_NT))


def largest_errors(found: Array, truth: Array) -> Array:
    """Return the largest error (4,) of offset (nT), scale, non-orthogonality (degrees), misalignment (degrees)."""
    error = np.abs(found - truth).reshape(SENSORS, 12)
    parts = (OFFSET, STRENGTH_NT), (SCALE, 1.0), (AXES, np.degrees(1.0)), (TURN, np.degrees(1.0))
    return np.array([unit * error[:, part].max() for part, unit in parts])


def residual_rms(parameters: Array, array_nT: Array) -> Array:
    """Return the rms (6,) of corrected total minus F (nT) and of the five tensor components (nT/m)."""
    h_nT = STRENGTH_NT * corrected(parameters, array_nT / STRENGTH_NT)
    total = np.linalg.norm(h_nT, axis=2) - STRENGTH_NT
    return np.sqrt([np.mean(total**2), *np.mean(tensor(h_nT, BASELINE_M) ** 2, axis=0)])


def bound(truth: Array4, noise_std_nT: float) -> Array:
    """Return the Cramer-Rao bound (45, 45) of the free parameters, vector units, for white noise on every axis.

    m_i = S_i h + b_i with |h| = F: the direction of h is a nuisance parameter of each sample and is projected out.
    """
    p, free = truth.parameters, free_parameters(SENSORS)
    h = corrected(p, truth.clean_nT / STRENGTH_NT)[0]
    forward = _measured(p, h)
    columns = [(_measured(p + step, h) - _measured(p - step, h)) / 2e-6 for step in 1e-6 * np.eye(len(p))[free]]
    G = np.stack(columns, axis=2)
    one = np.cross(h, [0.3, 0.5, 0.8])
    tangents = np.stack((one, np.cross(h, one)), axis=1) * 1e-6
    N = np.stack([_measured(p, h + tangents[:, k]) - forward for k in range(2)], axis=2)
    Q = np.linalg.qr(N)[0]
    seen = G - Q @ (Q.transpose(0, 2, 1) @ G)
    information = np.einsum("tdp,tdq->pq", seen, seen) * (STRENGTH_NT / noise_std_nT) ** 2
    return np.asarray(np.linalg.inv(information))


def _measured(p: Array, h: Array) -> Array:
    """Return measurements (n, 12) in units of F of true fields h (n, 3)."""
    matrix, _ = maps(p, SENSORS)
    offset = p.reshape(SENSORS, 12)[:, OFFSET]
    return np.concatenate([h @ np.linalg.inv(matrix[i]).T + offset[i] for i in range(SENSORS)], axis=1)


WEIGHTS = ((1 / 3, 1.0, 0.0), (3.0, 1.0, 0.0), (1.0, 0.0, 0.0), (1.0, 3.0, 0.0), (1.0, 1.0, 1.0))
"""Weights of components, tensor and invariants tried beside (1, 1, 0)."""


@dataclass(frozen=True)
class SpreadTask:
    """Calibrate an array by least squares and by two steps; with `evolve` also by the evolution alone."""

    case: int
    noise_nT: float
    seed: int
    common: bool = False
    evolve: bool = False


def spread_trial(task: SpreadTask) -> dict[str, Any]:
    """Return errors and residuals of an array, by name."""
    array = simulate(task.case, task.noise_nT, task.seed, common=task.common)
    array_nT = array.recording.array_mag_nT
    assert array_nT is not None
    fit = LeastSquaresGradiometer(start="two_step").fit(array.recording, REFERENCE)
    found, two_step = vector_of(fit), vector_of(TwoStepGradiometer().fit(array.recording, REFERENCE))
    corrected_nT = STRENGTH_NT * corrected(found, array.clean_nT / STRENGTH_NT)
    out: dict[str, Any] = {
        "status": fit.status.kind,
        "errors": largest_errors(found, array.parameters),
        "two_step": largest_errors(two_step, array.parameters),
        "rms": residual_rms(found, array_nT),
        "raw": residual_rms(nominal(), array_nT),
        "systematic": float(np.abs(tensor(corrected_nT, BASELINE_M)).max()),
    }
    if task.noise_nT:
        out |= _against_bound(array, found, task.noise_nT)
    if task.evolve:
        out |= _evolved(array, found, task)
    return out


def deviations(array: Array4, noise_nT: float) -> Array:
    """Return the bound's standard deviations (45,); noise uniform within +-a has a / sqrt(3)."""
    return np.asarray(np.sqrt(np.diag(bound(array, noise_nT / np.sqrt(3.0)))))


def _against_bound(array: Array4, found: Array, noise_nT: float) -> dict[str, Any]:
    """Return errors over the bound, and the bound of the least certain offset."""
    free, std = free_parameters(SENSORS), deviations(array, noise_nT)
    return {
        "over_bound": (found - array.parameters)[free] / std,
        "bound_offset_nT": STRENGTH_NT * std[np.isin(free % 12, OFFSETS)].max(),
    }


def _evolved(array: Array4, found: Array, task: SpreadTask) -> dict[str, Any]:
    """Return errors of the evolution alone; with noise also distances from least squares in units of the bound.

    The distances by weights too: without noise all weights have the same minimum, the true parameters.
    """

    def ends(components: float, tensor: float, invariants: float) -> Array:
        method = IdeGradiometer(polish=False, components=components, tensor=tensor, invariants=invariants)
        return searched(method, array, task.seed).parameters

    def apart(end: Array) -> float:
        return float(np.abs((end - found)[free] / std).max())

    evolved = ends(1.0, 1.0, 0.0)
    out: dict[str, Any] = {"evolved_errors": largest_errors(evolved, array.parameters)}
    if task.noise_nT:
        free, std = free_parameters(SENSORS), deviations(array, task.noise_nT)
        weighted = [ends(*weights) for weights in WEIGHTS]
        out |= {
            "evolved_apart": apart(evolved),
            "weights": [apart(end) for end in weighted],
            "weights_errors": [largest_errors(end, array.parameters)[0] for end in weighted],
        }
    return out


def nominal() -> Array:
    """Return the parameters (48,) of a perfect array."""
    return np.tile([0.0] * 3 + [1.0] * 3 + [0.0] * 6, SENSORS)


def task_of(array: Array4, method: GradiometerCalibrator) -> ArrayObjective:
    """Return the objective of an array with a method's weights."""
    assert array.recording.array_mag_nT is not None
    return array_objective(
        array.recording.array_mag_nT, STRENGTH_NT, method.components, method.tensor, method.invariants
    )


def searched(method: GradiometerCalibrator, array: Array4, seed: int) -> ArrayEstimate:
    """Run a method's own search, without polish and final checks."""
    return method.search(task_of(array, method), array.recording, REFERENCE, stream(2021, seed, "search"))

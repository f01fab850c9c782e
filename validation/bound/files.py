"""Experiments of scenarios and of measured recordings."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from calib import Reference, get
from calib.methods.gyro_accel_ml import LEAST_LEVEL_M_S2, lasting
from calib.models.levelled import STANDARD_GRAVITY_M_S2
from calib.numerics.noise import white_noise_std
from calib.numerics.rates import world_to_body
from calib.result import Calibration
from recordings import Recording, Truth, read_recording
from recordings.manifest import file_of
from recordings.reading import Reading
from scenarios.arrays import Array
from scenarios.errors import InputError
from sim.effects.base import Effect
from sim.memory_run import run_in_memory
from sim.motion import Motion
from sim.scenario import Scenario
from sim.simulation import PreparedRun, plan
from validation.bound.experiment import Experiment
from validation.bound.sensor_noise import stated_colour, stated_noise_nT
from validation.calibrating.reference import reference_of, told_field
from validation.scoring.hold_out import Environment, hold_out
from validation.signals.intervals import gaps_after

VECTOR = "vector_least_squares"
"""Name of the calibrator with directions from the attitude."""
ROUNDING_NT = 1e-6
"""Noise that rounding leaves of a simulated field without noise."""


def scenario_experiment(scenario: Scenario, noise_std_nT: float | None = None, *, coloured: bool = False) -> Experiment:
    """Return the experiment of a simulated run: true field and motion, matrix and white noise of the first sensor.

    The gyro's noise is the scenario's; `coloured` adds the scenario's flicker noise and random walk.
    noise_std_nT : white noise; None for the scenario's, as stated, or measured where no white noise is stated.
    Raises InputError if the vehicle cannot perform the motion, and without noise.
    """
    return run_experiment(plan(scenario), noise_std_nT, coloured=coloured)


def run_experiment(
    run: PreparedRun,
    noise_std_nT: float | None = None,
    *,
    coloured: bool = False,
    motions: Iterable[Motion] | None = None,
) -> Experiment:
    """Return the experiment of a planned run, see `scenario_experiment`; simulated here unless motions are given.

    Raises InputError in a zero field, and without noise.
    """
    if not np.any(run.field_enu_nT):
        what = "the field is zero: it has neither a direction nor a strength to calibrate by"
        raise InputError(what, where=run.scenario.name, do="give a field, as by --set field.enu_nT=[0,20000,-45000]")
    recording, truth = run_in_memory(run, motions)
    if noise_std_nT is None:
        noise_std_nT = stated_noise_nT(run.effects[0])
    known = true_experiment(recording, truth, run.effects[0], run.field_enu_nT, run.scenario.name, noise_std_nT)
    colour = stated_colour(run.effects[0]) if coloured else None
    return replace(known, gyro_std_rad_s=run.drawn.navigation.gyro_noise_std_rad_s, colour=colour)


def true_experiment(
    recording: Recording,
    truth: Truth,
    effects: tuple[Effect, ...],
    field_enu_nT: Array,
    where: str,
    noise_std_nT: float | None = None,
) -> Experiment:
    """Return the experiment of a recording with truth: true field and motion, matrix of the effects, white noise.

    Raises InputError without noise.
    """
    sensor = hold_out(effects, Environment.of(recording, field_enu_nT))
    residual_nT = recording.mag_nT - truth.field_nT @ sensor.matrix.T - sensor.offset_nT
    found = _white(residual_nT, recording.time_s) if noise_std_nT is None else noise_std_nT
    noise = found if found > ROUNDING_NT else 0.0
    known = _along(truth.field_nT, sensor.matrix, noise, recording.time_s, _turns_of(truth.q), where)
    return _levelled(replace(known, field_enu_nT=field_enu_nT), truth.q, recording)


def recording_experiment(
    path: Path,
    *,
    noise_std_nT: float | None = None,
    run: int = 0,
    reading: Reading | None = None,
    strength_nT: float | None = None,
    enu: Sequence[float] | None = None,
) -> Experiment:
    """Return the experiment of a measured file, see `experiment_of`; InputError for unusable files and references."""
    file = file_of(path, run)
    recording = read_recording(file, reading=reading)
    reference = reference_of(file, *told_field(strength_nT, enu, recording.origin, recording.mag_nT))
    return experiment_of(recording, reference, noise_std_nT, str(file))


def experiment_of(
    recording: Recording, reference: Reference, noise_std_nT: float | None = None, where: str = "recording"
) -> Experiment:
    """Return the experiment of a measured recording: field and matrix from a calibration, by attitude if recorded.

    If all calibrators fail, S = I and the field is that of the attitude, or the measured field (with hard iron). The
    strength determines one component of the noise, |h| - F over |S^-T u|. Turns are those of the attitude, or of the
    gyro without attitude.
    Raises InputError without noise.
    """
    found = _seen(recording, reference)
    noise = _white(found.residual_nT, recording.time_s) if noise_std_nT is None else noise_std_nT
    known = _along(found.field_nT, found.matrix, noise, recording.time_s, _turns(recording), where)
    if recording.att_q is not None:
        known = _levelled(known, recording.att_q, recording)
    enu_nT = reference.field_enu_nT
    return known if enu_nT is None else replace(known, field_enu_nT=np.array(enu_nT))


@dataclass(frozen=True, eq=False)
class _FittedField:
    """Field (n, 3) and matrix (3, 3) of a recording, and the residual (n, 3 or 1), nT."""

    field_nT: Array
    matrix: Array
    residual_nT: Array


def _seen(recording: Recording, reference: Reference) -> _FittedField:
    fit = _fitted(recording, reference)
    measured_nT = recording.mag_nT if fit is None else fit.apply(recording)
    matrix = np.asarray(np.eye(3) if fit is None else np.linalg.inv(fit.matrix))
    if (fit is None or fit.name == VECTOR) and recording.att_q is not None and reference.field_enu_nT is not None:
        field_nT = world_to_body(recording.att_q, np.array(reference.field_enu_nT))
        return _FittedField(field_nT, matrix, (measured_nT - field_nT) @ matrix.T)
    size_nT = np.linalg.norm(measured_nT, axis=1)[:, None]
    field_nT = np.asarray(reference.strength_nT * measured_nT / size_nT)
    gain = np.linalg.norm((measured_nT / size_nT) @ np.linalg.inv(matrix), axis=1)[:, None]
    return _FittedField(field_nT, matrix, (size_nT - reference.strength_nT) / gain)


def _fitted(recording: Recording, reference: Reference) -> Calibration | None:
    """Return the first successful calibration, from most to least parameters; None if all fail."""
    for name in (VECTOR, "ellipsoid", "sphere"):
        fit = get(name).fit(recording, reference)
        if fit.status.kind == "ok":
            return fit
    return None


def _white(residual_nT: Array, time_s: Array) -> float:
    """Return the white noise of a residual, rms over the axes."""
    return float(np.sqrt(np.mean(white_noise_std(residual_nT, gaps_after(time_s)) ** 2)))


def _levelled(known: Experiment, q: Array, recording: Recording) -> Experiment:
    """Return the experiment with the accelerometer's vertical and noise, by an attitude (n, 4)."""
    if recording.accel_m_s2 is None:
        return known
    up = Rotation.from_quat(q, scalar_first=True).as_matrix()[:, 2]
    noise = lasting(recording.accel_m_s2 - STANDARD_GRAVITY_M_S2 * up)
    return replace(known, up=up, accel_std_m_s2=max(noise, LEAST_LEVEL_M_S2))


def _turns(recording: Recording) -> Array | None:
    if recording.att_q is not None:
        return _turns_of(recording.att_q)
    if recording.gyro_rad_s is None:
        return None
    step = (recording.gyro_rad_s[:-1] + recording.gyro_rad_s[1:]) / 2 * np.diff(recording.time_s)[:, None]
    return np.asarray(Rotation.from_rotvec(-step).as_matrix())


def _turns_of(q: Array) -> Array:
    attitude = Rotation.from_quat(q, scalar_first=True)
    return np.asarray((attitude[1:].inv() * attitude[:-1]).as_matrix())


def _along(field_nT: Array, matrix: Array, noise: float, time_s: Array, turns: Array | None, where: str) -> Experiment:
    if not noise > 0:
        what = "there is no white noise, so accuracy has no limit"
        raise InputError(what, where=where, do="give --noise-std-nT")
    return Experiment(field_nT, matrix, noise, turns, np.diff(time_s))

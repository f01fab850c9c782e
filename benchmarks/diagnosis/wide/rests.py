"""Measured rests as nulls: what a log leaves once its effects are taken off, with its causes shifted in time.

Logs lie in the folder that MAGBENCH_REALDATA names; without it there are no such trials.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np
from scipy.ndimage import median_filter
from scipy.signal import istft, stft

from benchmarks.diagnosis.wide.courses import DRAWN, course
from benchmarks.diagnosis.wide.making import Made
from recordings import Recording
from recordings.reader import read_recording
from scenarios.arrays import Array
from sim.rotation import matrix_from_q, to_body
from sim.scenario import ModelSpec

FOLDER = "MAGBENCH_REALDATA"
WHEELS = tuple(f"wheel_{k}_rad_s" for k in range(3))
LOGS: dict[str, tuple[tuple[str, ...], int]] = {
    "cubesat/rods": (("rod_x_A_m2", "rod_y_A_m2", "rod_z_A_m2"), 1),
    "cubesat/wheel_0": (WHEELS, 1),
    "cubesat/wheel_1": (WHEELS, 1),
    "cubesat/wheel_2": (WHEELS, 1),
    "glider/five_dives": ((), 1),
    "motion-capture/trial_21": ((), 6),
    "motion-capture/trial_32": ((), 6),
    "quadrotor/dot1_111110": ((), 2),
    "quadrotor/dot2_111109": ((), 2),
    "quadrotor/dot7_111109": ((), 2),
    "observatory/boulder_week": ((), 1),
}
"""Log -> its columns that are taken for motor currents, and every how many samples are taken."""
FIELD_ENU_NT = np.array([800.0, 24_000.0, -36_000.0])
"""The field that the rests of logs with attitude are put into."""
MOST_REST_NT = 1000.0
"""Rms above which a rest is made smaller: beside a field of 35,000 nT a sensor at rest is to be seen as one."""
MAGNET_S = {"motion-capture/trial_32": (33.5, 90.7)}
"""From when to when a magnet is attached to the case, which is what this trial of its authors is about."""
TONE, NEIGHBOURS = 3.0, 31
"""A rotor's tone stands so many times over the median size of so many frequencies about it."""
MOST_COMMANDS = 64
"""Different commands of a log up to which each has a field of its own: a rod's is no line in its command."""
SHIFTS = (0.15, 0.85)
"""Shares of the log by which causes are shifted."""
CAUSES, REST = "causes", "rest"


def shifted_names(seed: int) -> Sequence[str]:
    """The null trials of a seed: each log that has causes, with these shifted, and with the whole rest shifted."""
    with_causes = [name for name in rest_names() if name != "observatory/boulder_week"]
    return [f"{name}:{what}" for name in with_causes for what in (CAUSES, REST)]


def rest_names() -> list[str]:
    """The logs that are there."""
    folder = os.environ.get(FOLDER)
    return [name for name in LOGS if folder and (Path(folder) / f"{name}.parquet").exists()]


def shifted(name: str, seed: int) -> Made:
    """A log's rest in a field without error, its causes (or the rest) rolled in time by a share drawn for a seed."""
    log_name, _, what = name.partition(":")
    log, rest = _rest_of(log_name)
    by = int(np.random.default_rng([seed, *name.encode()]).uniform(*SHIFTS) * len(log))
    made = _rolled(log, by) if what == CAUSES else log
    rest = rest if what == CAUSES else np.roll(rest, by, axis=0)
    mag_nT = rest + (np.full(3, 2e4) if log.att_q is None else to_body(_turns(log), FIELD_ENU_NT[None]))
    return Made(replace(made, mag_nT=mag_nT), _model(), log_name, fitted_base=True)


def beside(name: str, seed: int) -> Made:
    """A simulated motion with a measured rest of random phases: its spectrum, sample by sample, and its axes' mix."""
    rng = np.random.default_rng([seed, *name.encode(), 5])
    vehicle = sorted(DRAWN)[int(rng.integers(len(DRAWN)))]
    flown = course(vehicle, seed)
    recording = flown.recorded(flown.field_nT, rng)
    rest = _random_phases(_rest_of(name)[1], len(recording), rng)
    rest *= np.exp(rng.uniform(np.log(1), np.log(20))) / rest.std()
    return Made(replace(recording, mag_nT=recording.mag_nT + rest), _model(flown.field_enu_nT), name, fitted_base=True)


def _model(field_enu_nT: Array = FIELD_ENU_NT) -> ModelSpec:
    return ModelSpec.model_validate({"field": {"enu_nT": field_enu_nT.tolist()}})


@lru_cache(maxsize=2)
def _rest_of(name: str) -> tuple[Recording, Array]:
    """A log with its causes, and what least squares in all of them leave (n, 3) of each axis."""
    columns, every = LOGS[name]
    log = _thinned(read_recording(Path(os.environ[FOLDER]) / f"{name}.parquet"), every)
    if columns:
        current_A = np.stack([log.channels[c] for c in columns], axis=1)
        left = {key: values for key, values in log.channels.items() if key not in columns}
        log = replace(log, current_A=current_A, channels=left)
    X = _causes(name, log)
    X = np.column_stack([X / np.maximum(np.abs(X).max(axis=0), 1e-300), np.ones(len(log))])
    rest = log.mag_nT - X @ np.linalg.lstsq(X, log.mag_nT, rcond=1e-10)[0]
    rest = _without_tones(rest) if columns == WHEELS else rest
    return log, rest * min(1.0, MOST_REST_NT / float(rest.std()))


def _causes(name: str, log: Recording) -> Array:
    """Columns (n, k) that take off what a log holds: attitude, its rate, both times the place, channels, a magnet."""
    columns = [_magnet(name, log), _commands(log)]
    if log.att_q is not None:
        R = _turns(log).reshape(len(log), 9)
        columns += [R, _rate(R, log)]
        if log.pos_enu_m is not None:
            moved = log.pos_enu_m - log.pos_enu_m.mean(axis=0)
            columns += [np.einsum("ni,nj->nij", R, moved).reshape(len(log), 27)]
    for values in _scalars(log):
        columns += [values[:, None], _rate(values[:, None], log)]
    return np.concatenate(columns, axis=1)


def _magnet(name: str, log: Recording) -> Array:
    begin_s, end_s = MAGNET_S.get(name, (0.0, 0.0))
    return ((begin_s < log.time_s) & (log.time_s < end_s)).astype(float)[:, None]


def _commands(log: Recording) -> Array:
    """Columns (n, k) of ones where a command is given, of each command of a log that has few."""
    if log.current_A is None:
        return np.zeros((len(log), 0))
    every, which = np.unique(log.current_A, axis=0, return_inverse=True)
    return np.eye(len(every))[which.ravel()] if len(every) <= MOST_COMMANDS else np.zeros((len(log), 0))


def _without_tones(rest: Array) -> Array:
    """A rest (n, 3) whose lines, those of the wheels' rotors, are cut down to what stands about them."""
    spectrum = stft(rest.T)[2]
    size = np.abs(spectrum)
    usual = median_filter(size, (1, NEIGHBOURS, 1))
    cut = spectrum * np.where(size > TONE * usual, usual / np.maximum(size, 1e-300), 1.0)
    return np.asarray(istft(cut)[1].T[: len(rest)])


def _rate(values: Array, log: Recording) -> Array:
    return np.asarray(np.gradient(values, log.time_s, axis=0))


def _scalars(log: Recording) -> list[Array]:
    currents = [] if log.current_A is None else list(log.current_A.T)
    heat = [] if log.temperature_degC is None else [log.temperature_degC]
    return [one for one in [*currents, *heat, *log.channels.values()] if np.isfinite(one).all() and np.ptp(one) > 0]


def _turns(log: Recording) -> Array:
    assert log.att_q is not None
    return np.asarray(matrix_from_q(np.ascontiguousarray(log.att_q)))


def _thinned(log: Recording, every: int) -> Recording:
    def of(values: Array | None) -> Array | None:
        return None if values is None else values[::every]

    return Recording(
        log.time_s[::every] - log.time_s[0],
        log.mag_nT[::every],
        att_q=of(log.att_q),
        pos_enu_m=of(log.pos_enu_m),
        temperature_degC=of(log.temperature_degC),
        current_A=of(log.current_A),
        channels={name: values[::every] for name, values in log.channels.items()},
    )


def _rolled(log: Recording, by: int) -> Recording:
    """A log with its causes rolled in time; attitude stays, which the field goes with."""

    def of(values: Array | None) -> Array | None:
        return None if values is None else np.roll(values, by, axis=0)

    return replace(
        log,
        pos_enu_m=of(log.pos_enu_m),
        temperature_degC=of(log.temperature_degC),
        current_A=of(log.current_A),
        channels={name: np.roll(values, by) for name, values in log.channels.items()},
    )


def _random_phases(rest: Array, n: int, rng: np.random.Generator) -> Array:
    """Noise (n, 3) with a rest's spectrum over frequencies in cycles a sample, and its covariance of the axes."""
    mixing = np.linalg.cholesky(np.cov(rest.T) + 1e-12 * np.eye(3))
    apart: Array = np.linalg.solve(mixing, (rest - rest.mean(axis=0)).T).T
    window = np.sin(np.pi * (np.arange(len(rest)) + 0.5) / len(rest))[:, None] ** 2
    size = np.abs(np.fft.rfft(apart * window, axis=0))
    f, given = np.fft.rfftfreq(n), np.fft.rfftfreq(len(rest))
    phases = np.exp(2j * np.pi * rng.uniform(size=(len(f), 3)))
    spectrum = np.stack([np.interp(f, given, column) for column in size.T], axis=1) * phases
    out = np.fft.irfft(spectrum, n, axis=0)
    return np.asarray((out / out.std(axis=0)) @ mixing.T)

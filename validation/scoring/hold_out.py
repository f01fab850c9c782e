"""Hold-out motions for scoring, measured through the static part of the true magnetometer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation

from recordings import Recording
from recordings.assemble import scalars_of
from recordings.channels import TEMPERATURE
from scenarios.arrays import Array
from sim.chain import ChainLink
from sim.effects.base import Effect
from sim.effects.sources import dipole_field_nT
from sim.state import State

SPHERE_ATTITUDES = 2000
LEVEL_ATTITUDES = 720
LEVEL_TILT_RAD = float(np.radians(3.0))
LINE_HALF_LENGTH_M, LINE_SPACING_M = 60.0, 0.5
DIPOLE_ENU_M = np.array([5.0, 8.0, -20.0])
DIPOLE_PEAK_NT = 100.0
NOMINAL_DEGC = 20.0
MANOEUVRES_DEG = {"X": 10.0, "Y": 5.0, "Z": 5.0}
"""Amplitude of the figure-of-merit manoeuvres about each body axis: roll, pitch, yaw [Sheriff2002]."""
HEADINGS = 4
MANOEUVRE_SAMPLES = 41
"""Samples of one full swing; odd, so both extremes are sampled."""


@dataclass(frozen=True)
class Environment:
    """Mean conditions of a run: field_enu_nT (3,), time at mid-run, mean of each channel."""

    field_enu_nT: Array
    time_s: float = 0.0
    channels: Mapping[str, float] = field(default_factory=lambda: {TEMPERATURE: NOMINAL_DEGC})

    @classmethod
    def of(cls, recording: Recording, field_enu_nT: Sequence[float] | Array) -> Environment:
        """Return the mean conditions of a recording; a missing temperature becomes NOMINAL_DEGC."""
        mean = {name: float(np.nanmean(values)) for name, values in scalars_of(recording).items()}
        return cls(
            np.asarray(field_enu_nT, dtype=float),
            float(recording.time_s[0] + recording.time_s[-1]) / 2,
            {TEMPERATURE: NOMINAL_DEGC} | mean,
        )


@dataclass(frozen=True)
class HoldOutMotion:
    """Attitudes R_wb (n, 3, 3), true field (n, 3) and measured field (n, 3), body frame, nT."""

    R_wb: Array
    true_nT: Array
    measured_nT: Array

    def recording(self) -> Recording:
        """Return the measurement as a recording at rest, for `Calibration.apply`."""
        n = len(self.measured_nT)
        return Recording(np.arange(n, dtype=float), self.measured_nT, gyro_rad_s=np.zeros((n, 3)))


@dataclass(frozen=True)
class HoldOut:
    """Static truth m = S h + b (matrix S (3, 3), offset_nT b (3,)) and four motions without noise.

    sphere : attitudes uniform over all rotations. level : headings all round, roll and pitch within 3 degrees.
    line : a survey line, out and back, over a seabed dipole with a peak of 100 nT, roll and pitch within 3 degrees.
    manoeuvres : a roll, a pitch and a yaw on each of four headings, MANOEUVRE_SAMPLES each.
    """

    matrix: Array
    offset_nT: Array
    sphere: HoldOutMotion
    level: HoldOutMotion
    line: HoldOutMotion
    line_anomaly_nT: Array
    manoeuvres: HoldOutMotion


def hold_out(effects: Sequence[Effect], environment: Environment) -> HoldOut:
    """Return the hold-out of a magnetometer with effects in the order of the chain."""
    sphere = simulate_motion(effects, environment, uniform_attitudes(SPHERE_ATTITUDES))
    matrix, offset_nT = _linear(sphere)
    pos_m, attitudes = survey_line()
    anomaly_enu_nT = dipole_enu_nT(pos_m, environment.field_enu_nT)
    line = simulate_motion(effects, environment, attitudes, anomaly_enu_nT)
    strength_nT = float(np.linalg.norm(environment.field_enu_nT))
    total_nT = np.linalg.norm(environment.field_enu_nT + anomaly_enu_nT, axis=1)
    level = simulate_motion(effects, environment, level_attitudes(LEVEL_ATTITUDES))
    swung = simulate_motion(effects, environment, manoeuvres())
    return HoldOut(matrix, offset_nT, sphere, level, line, np.asarray(total_nT - strength_nT), swung)


def simulate_motion(
    effects: Sequence[Effect], environment: Environment, attitudes: Rotation, extra_enu_nT: Array | None = None
) -> HoldOutMotion:
    """Return the true field, Earth field plus extra_enu_nT (n, 3), and the measurement through the static effects."""
    n = len(attitudes)
    world_nT = np.tile(environment.field_enu_nT, (n, 1)) + (0.0 if extra_enu_nT is None else extra_enu_nT)
    true_nT = np.asarray(attitudes.inv().apply(world_nT))
    state = _at_rest(environment, attitudes)
    signal_nT = true_nT.copy()
    for effect in effects:
        if effect.static:
            signal_nT, _ = ChainLink(effect, np.random.default_rng(0)).step(state, signal_nT)
    return HoldOutMotion(state.R_wb, true_nT, signal_nT)


def _at_rest(environment: Environment, attitudes: Rotation) -> State:
    """Return the state of n attitudes at the origin, at rest, at the time of the environment."""
    n, none = len(attitudes), np.zeros((len(attitudes), 3))
    return State(
        time_s=np.full(n, environment.time_s),
        interval_s=1.0,
        pos_enu_m=none,
        R_wb=np.asarray(attitudes.as_matrix()),
        rate_rad_s=none,
        field_enu_nT=environment.field_enu_nT,
        field_nT=np.asarray(attitudes.inv().apply(environment.field_enu_nT)),
        field_rate_nT_s=none,
        channels={name: np.full(n, value) for name, value in environment.channels.items()},
    )


def _linear(data: HoldOutMotion) -> tuple[Array, Array]:
    """Return S (3, 3) and b (3,) of the least-squares fit m = S h + b; exact for linear static effects."""
    scale_nT = float(np.linalg.norm(data.true_nT, axis=1).max())
    rows = np.column_stack((data.true_nT / scale_nT, np.ones(len(data.true_nT))))
    solution = np.linalg.lstsq(rows, data.measured_nT, rcond=None)[0]
    return np.asarray(solution[:3].T / scale_nT), np.asarray(solution[3])


def uniform_attitudes(n: int) -> Rotation:
    """Return n rotations, uniform over all, from a fixed seed."""
    return Rotation.random(n, rng=np.random.default_rng(0))


def level_attitudes(n: int) -> Rotation:
    """Return evenly spaced headings with roll and pitch within LEVEL_TILT_RAD, 7 and 11 swings a turn."""
    yaw = 2 * np.pi * np.arange(n) / n
    return _wobbling(yaw, 7 * yaw, 11 * yaw + 1)


def _wobbling(yaw: Array, pitch_phase: Array, roll_phase: Array) -> Rotation:
    pitch, roll = LEVEL_TILT_RAD * np.sin(pitch_phase), LEVEL_TILT_RAD * np.sin(roll_phase)
    return Rotation.from_euler("ZYX", np.column_stack((yaw, pitch, roll)))


def manoeuvres() -> Rotation:
    """Return a roll, a pitch and a yaw on headings north, west, south, east: a swing of MANOEUVRES_DEG each."""
    swing = np.sin(2 * np.pi * np.arange(MANOEUVRE_SAMPLES) / (MANOEUVRE_SAMPLES - 1))
    about = [
        Rotation.from_euler(axis, amplitude * swing[:, None], degrees=True)
        for axis, amplitude in MANOEUVRES_DEG.items()
    ]
    north = Rotation.from_euler("Z", 90.0, degrees=True)
    return Rotation.concatenate([north ** (1 + k) * turn for k in range(HEADINGS) for turn in about])


def survey_line() -> tuple[Array, Rotation]:
    """Return positions (n, 3) and attitudes of a line to the east and back, a sample every half metre."""
    along = np.arange(-LINE_HALF_LENGTH_M, LINE_HALF_LENGTH_M + LINE_SPACING_M / 2, LINE_SPACING_M)
    x = np.concatenate((along, along[::-1]))
    yaw = np.repeat([0.0, np.pi], len(along))
    return np.column_stack((x, 0 * x, 0 * x)), _wobbling(yaw, x / 3.0, x / 2.2 + 1)


def dipole_enu_nT(pos_m: Array, field_enu_nT: Array) -> Array:
    """Return the field (n, 3) of a dipole at DIPOLE_ENU_M along the Earth field, with a peak of DIPOLE_PEAK_NT."""
    unit_nT = dipole_field_nT(pos_m - DIPOLE_ENU_M, field_enu_nT / np.linalg.norm(field_enu_nT))
    return unit_nT * (DIPOLE_PEAK_NT / float(np.linalg.norm(unit_nT, axis=1).max()))

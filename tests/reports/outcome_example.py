"""A made-up outcome with the shape of a real one: an AUV's dive, spiral and comb, its effects and five calibrators."""

from __future__ import annotations

import numpy as np

from calib.result import Calibration, Status
from recordings.recording import Recording, Truth
from scenarios.arrays import Array
from scenarios.paths import PHASES, Ability
from sim.scenario import Scenario
from sim.vehicles import VEHICLES, vehicles_for
from validation.scoring.outcome import Outcome
from validation.scoring.scores import Score

FIELD_ENU_NT = np.array([1500.0, 27_000.0, -41_000.0])
OFFSET_NT = np.array([1200.0, -800.0, 450.0])
SOFT_IRON = np.array([[0.020, 0.006, -0.004], [0.006, -0.012, 0.003], [-0.004, 0.003, 0.015]])
TOTAL_OFFSET_NT = OFFSET_NT + np.array([6.0, 30.0, 8.0])
"""The hard iron with the mean of the currents' and the temperature's part."""
EDDY_S = np.diag([2e-2, 3e-2, 1e-2])
FAILURE = "every sample has the same <attitude> & rate: nothing can be told apart; move the vehicle"
RANGES = {"descent": 0.2, "spiral": 0.35, "comb": 0.45}


def example_scenario(vehicle: str = "auv") -> Scenario:
    """The scenario of the example."""
    tables = (
        {"kind": "descent", "to_depth_m": 40.0},
        {"kind": "spiral", "radius_m": 20.0, "turn_rate_deg_s": 3.0, "turns": 2.0},
        {"kind": "comb", "line_length_m": 60.0, "line_spacing_m": 12.0, "lines": 5, "speed_m_s": 1.0},
        {"kind": "tumble", "duration_s": 600.0},
    )
    return Scenario.model_validate({
        "name": "auv-example",
        "summary": "An AUV sinks, circles and surveys; a <b>steel</b> frame and its motors disturb the magnetometer.",
        "seed": 7,
        "field": {"enu_nT": FIELD_ENU_NT.tolist()},
        "vehicle": {"kind": vehicle},
        "phases": [table for table in tables if vehicle in vehicles_for(PHASES[str(table["kind"])])],
    })  # fmt: skip


def example_outcome(
    n: int = 9000, *, duration_s: float = 900.0, seed: int = 1, vehicle: str = "auv", sensors: int = 1
) -> Outcome:
    """An outcome of n samples; with several sensors, each has an offset of its own."""
    rng = np.random.default_rng(seed)
    time_s = np.linspace(0.0, duration_s, n)
    phase, pos_m, q = _motion(n) if Ability.TRAVEL in VEHICLES[vehicle].abilities else _tumble(n)
    rotation = _matrices(q)
    field_nT = np.einsum("nji,j->ni", rotation, FIELD_ENU_NT)
    current_A = np.abs(2 + np.sin(time_s[:, None] / (40 + 11 * np.arange(4))) + 0.05 * rng.standard_normal((n, 4)))
    current_A *= np.where(phase == "descent", 0.02, 1.0)[:, None]
    temperature = 4 + 14 * np.exp(pos_m[:, 2] / 25.0) + 0.01 * rng.standard_normal(n)
    effects = _effects(time_s, field_nT, current_A, temperature, rng)
    mag_nT = field_nT + sum(effects.values())
    several = np.stack([mag_nT + 30.0 * k for k in range(sensors)]) if sensors > 1 else None
    if several is not None:
        effects = {name: np.stack([value] * sensors) for name, value in effects.items()}
    recording = Recording(
        time_s=time_s, mag_nT=mag_nT, att_q=q, pos_enu_m=pos_m, temperature_degC=temperature, current_A=current_A,
        phase=phase, array_mag_nT=several,
    )  # fmt: skip
    tables = {
        "hard_iron": {"field_nT": OFFSET_NT.tolist()}, "soft_iron": {"matrix": SOFT_IRON.tolist()},
        "eddy_current": {"matrix_s": EDDY_S.tolist()}, "motor_current": {"gain_nT_A": [[3.0, 2.0, 1.0]] * 4},
        "white_noise": {"std_nT": 10.0},
    }  # fmt: skip
    parameters = {"field_enu_nT": FIELD_ENU_NT.tolist(), "effects": [tables] * sensors, "navigation": {"gyro_s": 1e-3}}
    truth = Truth(field_nT=field_nT, q=q, pos_enu_m=pos_m, effects=effects, parameters=parameters)
    calibrations = _calibrations(rng)
    corrected = {
        c.name: (mag_nT - c.offset_nT) @ c.matrix.T for c in calibrations.values() if c.status.kind != "not_applicable"
    }
    scores = {name: _scores(value, field_nT, calibrations[name].offset_nT) for name, value in corrected.items()}
    return Outcome(
        example_scenario(vehicle),
        recording,
        truth,
        calibrations,
        scores | {"gyro_ml": [Score("failure", 1.0, "")]},
        corrected,
    )


def _motion(n: int) -> tuple[np.ndarray, Array, Array]:
    """Phases, path and attitude: a nose-down dive, two circles going down, a comb of five lines."""
    ends = (np.cumsum(list(RANGES.values())) * n).round().astype(int)
    phase = np.repeat(list(RANGES), np.diff(ends, prepend=0))
    u = [np.linspace(0, 1, count) for count in np.diff(ends, prepend=0)]
    dive = np.stack([20 * u[0], 0 * u[0], -40 * u[0]], axis=1)
    turn = 4 * np.pi * u[1]
    circles = dive[-1] + np.stack([20 * np.sin(turn), 20 * (1 - np.cos(turn)), -5 * u[1]], axis=1)
    line = u[2] * 5
    number = np.minimum(np.floor(line), 4)
    along = line - number
    east = np.where(number % 2 == 0, 1, -1) * 60 * (np.clip(along / 0.9, 0, 1) - 0.5) + 30
    survey = circles[-1] + np.stack([east, 12 * (number + np.clip((along - 0.9) / 0.1, 0, 1)), 0 * line], axis=1)
    reverse = np.where(number % 2 == 0, 0.0, np.pi) + np.pi * np.clip((along - 0.9) / 0.1, 0, 1)
    yaw = np.concatenate([0 * u[0], turn, reverse])
    pitch = np.concatenate([0.6 * np.sin(np.pi * u[0]), 0.3 * np.sin(9 * turn), 0.08 * np.sin(40 * u[2])])
    roll = np.concatenate([0.1 * np.sin(20 * u[0]), 0.3 * np.sin(7 * turn), 0.1 * np.sin(50 * u[2])])
    return phase, np.concatenate([dive, circles, survey]), _quaternions(yaw, pitch, roll)


def _tumble(n: int) -> tuple[np.ndarray, Array, Array]:
    """All attitudes on a turntable that stays where it is."""
    u = np.linspace(0, 2 * np.pi, n)
    return np.full(n, "turntable"), np.zeros((n, 3)), _quaternions(3 * u, 1.4 * np.sin(7 * u), 3.0 * np.sin(11 * u))


def _quaternions(yaw: Array, pitch: Array, roll: Array) -> Array:
    cy, sy, cp, sp, cr, sr = (f(a / 2) for a in (yaw, pitch, roll) for f in (np.cos, np.sin))
    w, x = cy * cp * cr + sy * sp * sr, cy * cp * sr - sy * sp * cr
    return np.stack([w, x, cy * sp * cr + sy * cp * sr, sy * cp * cr - cy * sp * sr], axis=1)


def _matrices(q: Array) -> Array:
    w, v = q[:, 0], q[:, 1:]
    eye, cross = np.eye(3), np.zeros((len(q), 3, 3))
    cross[:, 0, 1], cross[:, 0, 2], cross[:, 1, 2] = -v[:, 2], v[:, 1], -v[:, 0]
    cross -= cross.transpose(0, 2, 1)
    scalar = (w**2 - np.sum(v**2, axis=1))[:, None, None]
    return scalar * eye + 2 * v[:, :, None] * v[:, None, :] + 2 * w[:, None, None] * cross


def _effects(
    time_s: Array, field_nT: Array, current_A: Array, temperature: Array, rng: np.random.Generator
) -> dict[str, Array]:
    n = len(time_s)
    spikes = np.zeros((n, 3))
    spikes[rng.integers(0, n, 6)] = 400.0 * rng.choice([-1, 1], (6, 3))
    return {
        "hard_iron": np.tile(OFFSET_NT, (n, 1)),
        "soft_iron": field_nT @ SOFT_IRON.T,
        "eddy_current": np.gradient(field_nT, time_s, axis=0) @ EDDY_S.T,
        "motor_current": current_A.sum(axis=1)[:, None] * np.array([3.0, 2.0, 1.0]),
        "temperature_offset": (temperature - 20)[:, None] * np.array([1.2, -0.8, 0.3]),
        "white_noise": rng.normal(scale=10.0, size=(n, 3)),
        "spikes": spikes,
    }


def _calibrations(rng: np.random.Generator) -> dict[str, Calibration]:
    exact = np.linalg.inv(np.eye(3) + SOFT_IRON)
    quality = {
        "sphere": (60.0, 1e-2),
        "ellipsoid": (15.0, 2e-3),
        "vector_least_squares": (3.0, 1e-4),
        "kalman": (9.0, 1e-3),
    }
    fits = {
        name: Calibration(
            name=name, status=Status("ok"), offset_nT=TOTAL_OFFSET_NT + offset * rng.standard_normal(3),
            matrix=exact + matrix * rng.standard_normal((3, 3)), wall_s=offset / 500,
        )
        for name, (offset, matrix) in quality.items()
    }  # fmt: skip
    slow = Status("not_converged", "200 rounds did not settle; raise rounds or start nearer")
    fits["psoga"] = Calibration(name="psoga", status=slow, offset_nT=OFFSET_NT * 0.9, matrix=exact, wall_s=1.2)
    fits["gyro_ml"] = Calibration(name="gyro_ml", status=Status("not_applicable", FAILURE))
    return fits


def _scores(corrected: Array, field_nT: Array, offset_nT: Array) -> list[Score]:
    error = corrected - field_nT
    norm = np.linalg.norm(corrected, axis=1) - np.linalg.norm(field_nT, axis=1)
    wrong, bent = float(np.sqrt(np.mean(error**2))), float(np.sqrt(np.mean(norm**2)))
    return [
        Score("offset_error", float(np.linalg.norm(offset_nT - OFFSET_NT)), "nT"),
        Score("matrix_error", wrong / 2e4, "", rotation_removed=True),
        Score("holdout_sphere_norm_rms", 0.8 * bent, "nT"),
        Score("holdout_sphere_component_rms", 1.1 * wrong, "nT", rotation_removed=True),
        Score("holdout_level_component_rms", 0.9 * wrong, "nT", rotation_removed=True),
        Score("heading_rms", wrong / 400, "deg", rotation_removed=True),
        Score("anomaly_rms", 0.2 * bent, "nT"),
        Score("failure", 0.0, ""),
        Score("iterations", 12.0, ""),
        Score("wall_time", 0.1, "s"),
        Score("in_sample_norm_rms", bent, "nT", in_sample=True),
    ]

"""Trials of [Li2017]: simulated turns, a quadrotor's survey, and Levenberg-Marquardt."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from calib import CALIBRATORS, Reference
from calib.families.vector_filter import FilterTrack, KalmanSettings, track
from calib.methods.kalman_fuzzy import KalmanFuzzyCalibrator
from calib.methods.kalman_rescaled import MICROTESLA
from calib.models.vector import VectorData
from calib.numerics.kalman import STEADY, Engine
from papers.attitudes import state_at_attitudes
from papers.li2017.rivals import RIVALS, SEED, TurnedField, truncated_state
from recordings import Recording, Truth
from recordings.assemble import recording_of, truth_of
from scenarios.arrays import Array
from sim.chain import Chain
from sim.effects import Effects
from sim.effects.earth import AttitudeMisalignment, DiurnalDrift, FieldGradient
from sim.effects.papers import li2017
from sim.effects.sources import LocalDipole
from sim.rotation import matrix_from_q
from sim.scenario import Scenario, load
from sim.simulation import blocks, plan
from sim.state import State
from validation.signals.amplitude import column_rms

FIELD_ENU_NT = (-1940.0, 31916.0, -41285.0)
REFERENCE = Reference.of_vector(FIELD_ENU_NT)
PERMANENT_NT = (40.0, -100.0, 120.0)
INDUCED = ((0.065, 0.1, 0.26), (0.02, 0.5, 0.28), (0.2, 0.26, 0.16))
EDDY_S = ((0.1, 0.32, 0.22), (0.13, 0.16, 0.61), (0.16, 0.17, 0.02))
TRUE_STATE = np.concatenate((PERMANENT_NT, np.ravel(INDUCED), np.ravel(EDDY_S)))
ANGLE_RATES_RAD_S = (0.30, 0.37, 0.23)
"""Yaw, pitch, roll: steady Euler rates turn all axes and excite all 21 columns."""
INTERVAL_S = 0.01
MOTIONS = (
    ((0.30, 0.37, 0.23), 0.05),
    ((1.0, 0.7, 0.43), 0.01),
    ((1.0, 0.7, 0.43), 0.1),
    ((0.10, 0.13, 0.07), 0.05),
    ((0.10, 0.13, 0.07), 0.01),
    ((0.010, 0.013, 0.007), 1.0),
)
"""Further rates and intervals tried; ANGLE_RATES_RAD_S was chosen since T_p error and settling are near the printed.

The last has dT/dt of tens to a thousand nT per unit of time, as stated in the paper.
"""
NOISE_STD_NT = 5.0
SAMPLES = 10_000
CALM = KalmanSettings(1000.0, state_variance=1e-8, noise_variance_nT2=NOISE_STD_NT**2)
"""A state variance so small that the measurement's noise rules the innovations, and the right noise at the start."""
CONSTANT = replace(CALM, state_variance=0.0)
"""The settings that suit the paper's data: a state that does not move, and the right noise."""
ENGINES: tuple[Engine, Engine] = ("filterpy", "compiled")
ENGINE_FILTERS = ("kf", "rescaled", "both")
EXPONENTS = (0.0, 1.0)
SETTLED = 0.05
TRUNCATED = "truncated total least squares of eq. 1"
LOUD = 10.0
"""Factor by which the noise grows in the last third of the run with changing noise."""
SOURCES = (AttitudeMisalignment.name, DiurnalDrift.name, FieldGradient.name, LocalDipole.name)
"""The four error sources that the paper names: alignment, reference field, uneven field, unknown surroundings."""
Vector = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class FilterErrors:
    """Errors of a filter on a run.

    state_error_pct (21,); errors e (n, 3) of the compensated field without noise: component_nT (3,) mean |e_i|,
    component_rms_nT (3,), total_nT mean length of e, strength_nT mean error of the strength; ratio: median ROR of the
    second half; noise_nT2: last R; settled: first sample from which every parameter stays within 20 %.
    """

    state_error_pct: Array
    component_nT: Array
    component_rms_nT: Array
    total_nT: float
    strength_nT: float
    ratio: float
    noise_nT2: float
    settled: int


def turning(samples: int, rates_rad_s: Vector = ANGLE_RATES_RAD_S, interval_s: float = INTERVAL_S) -> State:
    """Return the state of the carrier at uniform Euler rates about all axes."""
    time_s: Array = np.arange(samples, dtype=np.float64) * interval_s
    turn = _attitude(time_s, rates_rad_s)
    before, after = _attitude(time_s - 1e-5, rates_rad_s), _attitude(time_s + 1e-5, rates_rad_s)
    rate: Array = (before.inv() * after).as_rotvec() / 2e-5
    state = state_at_attitudes(turn.as_matrix(), np.array(FIELD_ENU_NT), interval_s)
    return replace(state, rate_rad_s=rate, field_rate_nT_s=-np.cross(rate, state.field_nT))


def _attitude(time_s: Array, rates_rad_s: Vector) -> Rotation:
    return Rotation.from_euler("ZYX", np.outer(time_s, rates_rad_s))


def simulated(seed: int, samples: int = SAMPLES, loud: float = 1.0, state: State | None = None) -> VectorData:
    """Simulate a run of table 1 by eq. 1; `loud` multiplies the noise of the last third; `state`: another motion."""
    state = turning(samples) if state is None else state
    clean, _ = Chain(li2017(PERMANENT_NT, INDUCED, EDDY_S), SEED, seed).apply(state)
    measured, _ = Chain(li2017(PERMANENT_NT, INDUCED, EDDY_S, NOISE_STD_NT), SEED, seed).apply(state)
    noise = measured - clean
    noise[2 * samples // 3 :] *= loud
    att_q = Rotation.from_matrix(state.R_wb).as_quat(scalar_first=True)
    recording = Recording(state.time_s, clean + noise, gyro_rad_s=state.rate_rad_s, att_q=att_q)
    return VectorData.of(recording, REFERENCE)


def outcome(data: VectorData, steps: FilterTrack) -> FilterErrors:
    """Return the errors of a filter's run."""
    error_pct = 100.0 * (steps.state - TRUE_STATE) / TRUE_STATE
    outside = np.flatnonzero(np.abs(error_pct).max(axis=1) > 20.0)
    clean = replace(data, difference_nT=data.observation() @ TRUE_STATE)
    error = compensated(steps.state[-1], clean) - data.field_nT
    strength = np.linalg.norm(data.field_nT + error, axis=1) - REFERENCE.strength_nT
    return FilterErrors(
        error_pct[-1],
        np.abs(error).mean(axis=0),
        column_rms(error),
        float(np.linalg.norm(error, axis=1).mean()),
        float(np.abs(strength).mean()),
        float(np.nanmedian(steps.ratio[len(error) // 2 :])),
        float(steps.noise_variance_nT2[-1]),
        int(outside[-1]) + 1 if len(outside) else 0,
    )


def compensated(state: Array, data: VectorData) -> Array:
    """Return (I + A)^-1 (T_m - T_p - B dT/dt) (n, 3), eq. 1 solved for T, for a state (21,)."""
    centred = data.difference_nT + data.field_nT - state[:3] - data.rate_nT_s @ state[12:].reshape(3, 3).T
    return np.asarray(np.linalg.solve(np.eye(3) + state[3:12].reshape(3, 3), centred.T).T)


def fuzzy_track(data: VectorData, settings: KalmanSettings, **options: float) -> FilterTrack:
    """Run the filter with fuzzy adaptation of R (section 2.3)."""
    return track(data, settings, rule=KalmanFuzzyCalibrator(settings, **options).noise_rule())  # type: ignore[arg-type]


def filter_trial(seed: int) -> dict[str, FilterErrors]:
    """Run every filter on a noise realisation."""
    data, changing = simulated(seed), simulated(seed, loud=LOUD)
    return {
        "kf": outcome(data, track(data, KalmanSettings())),
        "kf+fuzzy": outcome(data, fuzzy_track(data, KalmanSettings())),
        "rescaled": outcome(data, track(data, MICROTESLA)),
        "both": outcome(data, fuzzy_track(data, MICROTESLA)),
        "constant": outcome(data, track(data, CONSTANT)),
        "no floor": outcome(data, fuzzy_track(data, MICROTESLA, floor_nT2=1e-30)),
        "calm": outcome(changing, track(changing, CALM)),
        "calm+fuzzy": outcome(changing, fuzzy_track(changing, CALM)),
        "changing": outcome(changing, track(changing, MICROTESLA)),
        "changing+fuzzy": outcome(changing, fuzzy_track(changing, MICROTESLA)),
    }


def motion_trial(rates: tuple[Vector, float]) -> tuple[float, float, list[int]]:
    """Return T_p error of the original filter and mean error of the proposed filter, %, and settling, by motion.

    Settling: samples from which all parameters of the proposed filter stay within 20, 5 and 2 %.
    """
    data = simulated(0, state=turning(SAMPLES, *rates))
    original, steps = outcome(data, track(data, KalmanSettings())), fuzzy_track(data, MICROTESLA)
    worst = np.abs(100.0 * (steps.state - TRUE_STATE) / TRUE_STATE).max(axis=1)
    settled = [int(np.flatnonzero(worst > limit)[-1]) + 1 for limit in (20.0, 5.0, 2.0)]
    return (
        float(original.state_error_pct[:3].mean()),
        float(np.abs(outcome(data, steps).state_error_pct).mean()),
        settled,
    )


def changing_noise_trial(state_variance: float) -> tuple[float, float]:
    """Return the mean length of the error, nT, with R fixed and adapted, over five seeds of changing noise, by Q."""
    settings = replace(CALM, state_variance=state_variance)
    runs = [simulated(seed, loud=LOUD) for seed in range(5)]
    return (
        float(np.mean([outcome(d, track(d, settings)).total_nT for d in runs])),
        float(np.mean([outcome(d, fuzzy_track(d, settings)).total_nT for d in runs])),
    )


def long_trial(samples: int) -> Array:
    """Return the T_p error (3,), %, of the original filter after more samples."""
    data = simulated(0, samples)
    return outcome(data, track(data, KalmanSettings())).state_error_pct[:3]


@dataclass(frozen=True, eq=False)
class Survey:
    """Results of a survey: component rms (3,) raw and after each method, and settling sample of A.

    settled: sample from which A stays within SETTLED of the last values.
    """

    raw_nT: Array
    rms_nT: dict[str, Array]
    settled: dict[str, int]


def survey_trial(task: tuple[int, tuple[str, ...]]) -> Survey:
    """Fly the scenario quad-comb and run every method; task: seed and names of effects to switch off."""
    recording, truth = flown(*task)
    data = VectorData.of(recording, REFERENCE)
    rms, settled = {}, {}
    for name, settings in (("kalman", KalmanSettings()), ("kalman_rescaled", MICROTESLA), ("kalman_fuzzy", MICROTESLA)):
        steps = fuzzy_track(data, settings) if name == "kalman_fuzzy" else track(data, settings)
        rms[name] = column_rms(compensated(steps.state[-1], data) - truth.field_nT)
        away = np.abs(steps.state[:, 3:12] - steps.state[-1, 3:12]).max(axis=1) > SETTLED
        settled[name] = int(np.flatnonzero(away)[-1]) + 2 if away.any() else 1
    for name in ("vector_least_squares", "vector_lm"):
        rms[name] = column_rms(CALIBRATORS[name]().fit(recording, REFERENCE).apply(recording) - truth.field_nT)
    rms |= {name: column_rms(field - truth.field_nT) for name, field in _rival_fields(recording, data, task[0])}
    return Survey(column_rms(recording.mag_nT - truth.field_nT), rms, settled)


def _rival_fields(recording: Recording, data: VectorData, seed: int) -> Iterator[tuple[str, Array]]:
    """Yield the field (n, 3) compensated by each rival, and by truncated total least squares of eq. 1."""
    assert recording.att_q is not None
    seen = TurnedField(recording.mag_nT, matrix_from_q(recording.att_q)[:, 2], np.array(FIELD_ENU_NT), seed)
    for name, rival in RIVALS.items():
        yield name, rival(seen).apply(recording.mag_nT)
    yield TRUNCATED, compensated(truncated_state(data), data)


def flown(seed: int, without: tuple[str, ...] = ()) -> tuple[Recording, Truth]:
    """Return recording and truth of a survey."""
    scenario: Scenario = load("quad-comb")
    kept = {name: table for name, table in scenario.effects.written.items() if name not in without}
    ready = plan(scenario.model_copy(update={"effects": Effects(kept)}), 0, seed)
    pieces = list(blocks(ready))
    whole = {name: np.concatenate([piece[name] for piece in pieces]) for name in pieces[0]}
    return recording_of(whole), truth_of(whole, {})


def marquardt_trial(seed: int) -> dict[str, Array]:
    """Return the component rms (3,) over the run after solving for 21 unknowns, by equations and samples.

    Equations: vector, total field; samples: 200 spread over the run, the first 21.
    """
    data = simulated(seed)
    spread, first = np.arange(0, SAMPLES, 50), np.arange(21)
    start = np.concatenate((np.zeros(3), np.full(9, 0.01), np.full(9, 0.02)))
    rms: dict[str, Array] = {}
    for where, rows in (("200 spread", spread), ("21 consecutive", first)):
        part = VectorData(data.field_nT[rows], data.rate_nT_s[rows], data.difference_nT[rows])
        for what, equations in (("vector", vector_equations), ("total field", total_equations)):
            found = least_squares(equations, start, method="lm", args=(part,), max_nfev=3000)
            rms[f"{what}, {where}"] = column_rms(compensated(found.x, data) - data.field_nT)
    return rms


def vector_equations(state: Array, data: VectorData) -> Array:
    """Return three residuals per sample: compensated minus known field, nT."""
    return (compensated(state, data) - data.field_nT).ravel()


def total_equations(state: Array, data: VectorData) -> Array:
    """Return one residual per sample: compensated minus known field strength, nT."""
    return np.asarray(np.linalg.norm(compensated(state, data), axis=1) - REFERENCE.strength_nT)


def exponent_trial(exponent: float) -> float:
    """Return the largest change of ln R from its start under changing noise, by the exponent b."""
    data = simulated(0, loud=LOUD)
    R = track(data, CALM, rule=KalmanFuzzyCalibrator(CALM, exponent=exponent).noise_rule()).noise_variance_nT2
    return float(np.abs(np.log(R / CALM.noise_variance_nT2)).max())


def engine_trial(name: str) -> tuple[Array, Array]:
    """Return the last state (21,) of a filter by filterpy and by the compiled twin, on the first seed's noise."""
    data, settings = simulated(0), KalmanSettings() if name == "kf" else MICROTESLA
    rule = KalmanFuzzyCalibrator(settings).noise_rule() if name == "both" else STEADY
    filterpy, compiled = (track(data, settings, rule=rule, engine=engine).state[-1] for engine in ENGINES)
    return filterpy, compiled


def sensitivity_trial(seed: int) -> dict[tuple[int, float], tuple[int, float]]:
    """Return how the adaptation depends on window n and exponent b under changing noise.

    (n, b) -> samples from the jump until R is first within a factor of two of the truth, and the standard deviation of
    ln R from 1000 samples after the jump.
    """
    data = simulated(seed, loud=LOUD)
    jump, truth = 2 * SAMPLES // 3, (LOUD * NOISE_STD_NT) ** 2
    found = {}
    for window in (20, 50, 200):
        for exponent in (0.5, 1.0, 2.0):
            calibrator = KalmanFuzzyCalibrator(CALM, window=window, exponent=exponent)
            R = track(data, CALM, rule=calibrator.noise_rule()).noise_variance_nT2[jump:]
            found[window, exponent] = int(np.argmax(truth / 2 < R)), float(np.log(R[1000:]).std())
    return found

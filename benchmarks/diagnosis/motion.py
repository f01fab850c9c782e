"""Vehicles' motion for the trials, without any error of the magnetometer, and the colours that navigation adds."""

from __future__ import annotations

from dataclasses import replace
from functools import cache, lru_cache
from typing import Any

import numpy as np

from calib.numerics.rates import body_rate
from recordings import Recording
from recordings.assemble import recording_of, scalars_of
from scenarios.arrays import Array
from sim.processes import GaussMarkov
from sim.rotation import matrix_from_q, multiply_q, q_from_rotation_vector, to_body
from sim.scenario import Scenario, load
from sim.simulation import blocks, plan
from sim.state import State

SCENARIOS = ("auv-spiral-excited", "quad-calibration")
QUIET = ("navigation.attitude_noise_std_deg=0", "navigation.position_noise_std_m=0")
EXACT = {"temperature_noise_std_K": 0.0, "current_noise_std_A": 0.0}
ATTITUDE_DEG, CORRELATION_S, JITTER_S = 0.01, 60.0, 0.5e-3


@cache
def motions() -> dict[str, Scenario]:
    """The scenarios without errors, by the vehicle that moves."""
    bare: dict[str, Any] = {"effects": {}, "effect_order": None, "vary": {}}
    quiet = (load(name, list(QUIET)).model_copy(update=bare) for name in SCENARIOS)
    return {scenario.vehicle.kind: scenario for scenario in quiet}


@lru_cache(maxsize=4)
def flown(vehicle: str) -> tuple[Recording, State, Array]:
    """A vehicle's recording without magnetometer errors, the true state along it, and the field (east, north, up)."""
    return along(motions()[vehicle])


def along(scenario: Scenario) -> tuple[Recording, State, Array]:
    """The same of a scenario without errors; the channels' own noise is in the recording alone, and causes nothing."""
    exact = scenario.model_copy(update={"navigation": scenario.navigation.model_copy(update=EXACT)})
    whole, recording = _flown(scenario)
    _, causes = _flown(exact)
    field_enu_nT = plan(scenario, 0, 0).field_enu_nT
    return recording, _true_state(whole, causes, field_enu_nT), field_enu_nT


def _flown(scenario: Scenario) -> tuple[dict[str, Array], Recording]:
    """A run's columns, and what is recorded of them."""
    columns: dict[str, list[Any]] = {}
    for block in blocks(plan(scenario, 0, 0)):
        for key, values in block.items():
            columns.setdefault(key, []).append(values)
    whole = {key: np.concatenate(parts) for key, parts in columns.items()}
    return whole, recording_of({k: v for k, v in whole.items() if not k.startswith(("true_", "effect"))})


def _true_state(whole: dict[str, Array], recording: Recording, field_enu_nT: Array) -> State:
    truth_q = np.ascontiguousarray(np.stack([whole[f"true_q{a}"] for a in "wxyz"], axis=1))
    R_wb = matrix_from_q(truth_q)
    field_nT = to_body(R_wb, field_enu_nT[None])
    rate = body_rate(Recording(time_s=recording.time_s, mag_nT=np.zeros((len(recording), 3)), att_q=truth_q))
    assert rate is not None
    return State(
        time_s=recording.time_s,
        interval_s=float(recording.time_s[1] - recording.time_s[0]),
        pos_enu_m=np.stack([whole[f"true_pos_{a}_m"] for a in ("east", "north", "up")], axis=1),
        R_wb=R_wb,
        rate_rad_s=rate,
        field_enu_nT=field_enu_nT,
        field_nT=field_nT,
        field_rate_nT_s=-np.cross(rate, field_nT),
        channels=scalars_of(recording),
        attitude="navigation",
    )


def turned(recording: Recording, seed: int) -> Recording:
    """The recording with an attitude that wanders by 0.01 degree over a minute."""
    assert recording.att_q is not None
    step_s = float(np.median(np.diff(recording.time_s)))
    error = GaussMarkov(np.radians(ATTITUDE_DEG), CORRELATION_S, step_s, 3, np.random.default_rng([seed, 1]))
    return replace(
        recording, att_q=multiply_q(q_from_rotation_vector(error.draw(len(recording))), np.array(recording.att_q))
    )


def jittered(recording: Recording, mag_nT: Array, seed: int) -> Array:
    """A measurement (n, 3) taken half a millisecond, one standard deviation, beside its time stamps."""
    rng = np.random.default_rng([seed, 2])
    return np.asarray(
        mag_nT + np.gradient(mag_nT, recording.time_s, axis=0) * JITTER_S * rng.normal(size=(len(mag_nT), 1))
    )

"""What is hidden: every effect of the library with random parameters, brought to a strength in units of the noise."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.signal import lfilter

from recordings.channels import TEMPERATURE
from scenarios.arrays import Array
from scenarios.errors import InputError
from sim import effects as effect_table
from sim.chain import apply_deterministic
from sim.state import State

NOISE_NT = 2.0
ORIGIN_M = 300.0
"""Farthest origin of a gradient from the path's middle."""
BASE: dict[str, Any] = {
    "soft_iron": {"matrix": [[0.05, 0.01, -0.02], [0.01, -0.03, 0.015], [0.0, 0.01, 0.02]]},
    "hard_iron": {"offset_nT": [500.0, -300.0, 800.0]},
    "white_noise": {"std_nT": [NOISE_NT] * 3},
}
Tables = dict[str, Any]
Draw = Callable[[np.random.Generator, State], Any]


def _three(rng: np.random.Generator, size: float = 1.0) -> list[float]:
    return list(size * rng.normal(size=3))


def _dipoles(rng: np.random.Generator, state: State) -> Any:
    middle = state.pos_enu_m[int(rng.integers(len(state) // 4, 3 * len(state) // 4))] + np.array([4.0, 3.0, -6.0])
    moment = 50.0 * rng.normal(size=3)
    return [
        {"position_enu_m": (middle + shift).tolist(), "moment_A_m2": (share * moment).tolist()}
        for shift, share in ((np.zeros(3), 0.8), (np.array([0.6, 0.0, 0.0]), 0.2))
    ]


def _gradient(rng: np.random.Generator, state: State) -> Any:
    g = rng.normal(size=(3, 3)) * 0.1
    g = g + g.T
    middle = state.pos_enu_m.mean(axis=0)
    return {"gradient_nT_m": (g - np.eye(3) * np.trace(g) / 3).tolist(), "origin_enu_m": middle.tolist()}


def _elsewhere(rng: np.random.Generator, table: Any) -> Any:
    """The same gradient with an origin within 300 m, evenly in the ball: it brings a constant error of the field."""
    way = rng.normal(size=3)
    way *= ORIGIN_M * rng.uniform() ** (1 / 3) / np.linalg.norm(way)
    return {**table, "origin_enu_m": (np.array(table["origin_enu_m"]) + way).tolist()}


def _thrusters(rng: np.random.Generator, state: State) -> Any:
    """All motors alike, or one whose neighbour adds a twentieth."""
    motor, gain = int(rng.integers(0, 3)), np.array(_three(rng))
    main = {"gain_nT_A": gain.tolist(), "motor": motor}
    return main if motor == 0 else [main, {"gain_nT_A": (0.05 * gain).tolist(), "motor": motor + 1}]


def _ripple(rng: np.random.Generator, state: State) -> Any:
    """A tone with a second harmonic of a twentieth."""
    amplitude, tone = np.array(_three(rng)), float(rng.uniform(0.5, 2.0))
    phase = float(rng.uniform(-90, 90))
    return [
        {"amplitude_nT_A": (share * amplitude).tolist(), "frequency_hz": k * tone, "phase_deg": phase}
        for k, share in ((1, 1.0), (2, 0.05))
    ]


HIDDEN: dict[str, Draw] = {
    "regional_field": lambda rng, state: {"error_enu_nT": _three(rng, 100.0)},
    "diurnal_drift": lambda rng, state: {"amplitude_enu_nT": _three(rng, 50.0), "period_s": 43_200.0},
    "field_gradient": _gradient,
    "local_dipole": _dipoles,
    "attitude_misalignment": lambda rng, state: {"angles_deg": _three(rng, 0.02)},
    "hard_iron_drift": lambda rng, state: {"rate_nT_h": _three(rng, 10.0)},
    "eddy_current": lambda rng, state: {
        "matrix_s": (0.005 * (np.eye(3) + 0.2 * rng.normal(size=(3, 3)))).tolist(), "time_constant_s": 0.05,
    },
    "motor_current": _thrusters,
    "current_ripple": _ripple,
    "nonlinearity": lambda rng, state: {"second_order": _three(rng, 1e-3), "third_order": _three(rng, 1e-3)},
    "temperature_scale": lambda rng, state: {"slope_1_K": _three(rng, 1e-4)},
    "temperature_offset": lambda rng, state: {"slope_nT_K": _three(rng)},
    "hysteresis": lambda rng, state: {"gain": [2e-3, 3e-3, 2e-3], "threshold_nT": [800.0, 2000.0, 5000.0]},
    "bandwidth": lambda rng, state: {"cutoff_hz": float(rng.uniform(10, 30))},
    "latency": lambda rng, state: {"delay_s": float(rng.uniform(0.004, 0.012))},
    "offset_jump": lambda rng, state: {
        "time_s": float(rng.uniform(0.2, 0.8) * state.time_s[-1]), "step_nT": _three(rng),
    },
}  # fmt: skip
"""Deterministic effects before they are scaled: name -> (rng, state) -> tables."""
UNSTATED = {"latency", "bandwidth", "attitude_misalignment"}
"""Effects that a model does not state with another sign."""
MOVED: dict[str, Callable[[np.random.Generator, Any], Any]] = {"field_gradient": _elsewhere}
"""What is changed of an effect after it has been brought to its strength: the strength is that of its form alone."""
DIRECT: dict[str, Draw] = {
    "hard_iron": lambda rng, state: {"offset_nT": _three(rng, 5.0)},
    "sensor_offset": lambda rng, state: {"offset_nT": _three(rng, 5.0)},
    "soft_iron": lambda rng, state: {"matrix": (1e-4 * rng.normal(size=(3, 3))).tolist()},
    "scale": lambda rng, state: {"error": _three(rng, 2e-4)},
    "misalignment": lambda rng, state: {"angles_deg": _three(rng, 0.02)},
    "non_orthogonality": lambda rng, state: {"angles_deg": _three(rng, 0.02)},
    "white_noise": lambda rng, state: {"std_nT": [NOISE_NT * rng.uniform(0.7, 2.0)] * 3},
    "flicker_noise": lambda rng, state: {"density_nT_sqrt_hz": [float(rng.uniform(0.2, 1.0))] * 3},
    "offset_random_walk": lambda rng, state: {"std_nT_sqrt_s": [float(rng.uniform(0.1, 0.5))] * 3},
    "quantisation": lambda rng, state: {"step_nT": float(rng.uniform(1.0, 10.0))},
    "saturation": lambda rng, state: {
        "full_scale_nT": float(rng.uniform(0.85, 0.97) * np.abs(state.field_nT).max()),
    },
    "spikes": lambda rng, state: {
        "rate_hz": float(rng.uniform(0.05, 0.3)), "amplitude_nT": float(rng.uniform(60, 200)),
    },
    "dropouts": lambda rng, state: {"rate_hz": float(rng.uniform(0.02, 0.1)), "mean_duration_s": 0.5},
}  # fmt: skip
"""Noises, electronics and constants, hidden at the size that is drawn."""
EQUIVALENT = {
    "latency": {"bandwidth", "eddy_current"},
    "bandwidth": {"latency", "eddy_current"},
    "hard_iron": {"sensor_offset"},
    "sensor_offset": {"hard_iron"},
    "scale": {"soft_iron"},
    "misalignment": {"soft_iron"},
    "non_orthogonality": {"soft_iron", "misalignment"},
    "field_gradient": {"local_dipole"},
    "regional_field": {"attitude_misalignment"},
    "attitude_misalignment": {"regional_field"},
}
"""Declared equivalents and supersets: the same signal in smooth motion, in the base, or as a distant source's field."""
EXACT = (
    "regional_field", "attitude_misalignment", "hard_iron_drift", "diurnal_drift", "field_gradient",
    "nonlinearity", "offset_jump",
)  # fmt: skip
"""Effects whose truth has the candidate's own form, so that intervals can be held against it."""
PAIRS = (
    ("motor_current", "hysteresis"), ("eddy_current", "temperature_offset"), ("offset_jump", "nonlinearity"),
    ("diurnal_drift", "motor_current"), ("local_dipole", "current_ripple"), ("hard_iron_drift", "latency"),
)  # fmt: skip
"""What is hidden two at a time."""
FLICKER: Tables = {"flicker_noise": {"density_nT_sqrt_hz": [0.2] * 3}}
"""The colour of the sensor's own noise in a coloured null."""
POWER = {"delay_s": 1.0, "angles_deg": 1.0, "cutoff_hz": -1.0}
"""Parameters that scale with the strength, and its power, beside those that the effect is linear in."""


def hidden(name: str, strength: float, seed: int, state: State) -> Tables:
    """Tables of one hidden effect at a strength: rms after the base is refitted over the noise, by secant steps."""
    rng = np.random.default_rng([seed, 7])
    if name in DIRECT:
        return {name: DIRECT[name](rng, state)}
    tables, factor = HIDDEN[name](rng, state), 1.0
    felt = felt_by(name, state)
    for _ in range(3):
        factor *= strength / max(strength_of({name: times(name, tables, factor)}, felt), 1e-12)
    found = times(name, tables, factor)
    return {name: MOVED[name](rng, found) if name in MOVED else found}


def stated(name: str, factor: float, seed: int, state: State) -> tuple[Tables, Tables]:
    """Tables of one effect as it is and as the model states it, `factor` times as large.

    1 sigma apart, or half as far until neither is beyond the effect's bounds.
    """
    strength = 1.0 / abs(1.0 - factor)
    while True:
        try:
            true = hidden(name, strength, seed, state)
            model = {name: times(name, true[name], factor)}
            effect_table.build(model, None, "")
        except InputError:
            strength /= 2
        else:
            return true, model


def felt_by(name: str, state: State) -> State:
    """The state with a temperature that the sensor feels through two lags, 10 s and 2 s."""
    if TEMPERATURE not in effect_table.BY_NAME[name].needs:
        return state
    late = state.channel(TEMPERATURE)
    for lag_s in (10.0, 2.0):
        p = np.exp(-state.interval_s / lag_s)
        late, _ = lfilter([1 - p], [1, -p], late, zi=[p * late[0]])
    return replace(state, channels={**state.channels, TEMPERATURE: np.asarray(late)})


def strength_of(tables: Tables, state: State) -> float:
    """Rms that effects add to the base, after the base is refitted, over the noise of a sample."""
    base = {key: value for key, value in BASE.items() if key != "white_noise"}
    with_it = apply_deterministic(effect_table.build({**base, **tables}, None, ""), state)[0]
    without = apply_deterministic(effect_table.build(base, None, ""), state)[0]
    return beyond_base(with_it, without)


def beyond_base(with_it: Array, without: Array) -> float:
    """Rms of what a refitted base leaves of a signal (n, 3), over the noise of a sample."""
    design = np.column_stack([without / 5e4, np.ones(len(without))])
    left = with_it - design @ np.linalg.lstsq(design, with_it, rcond=None)[0]
    return float(np.sqrt((left**2).mean()) / NOISE_NT)


def times(name: str, table: Any, factor: float) -> Any:
    """A table of an effect with the size of its contribution times a factor."""
    if isinstance(table, list):
        return [times(name, one, factor) for one in table]
    powers = dict.fromkeys(effect_table.BY_NAME[name].linear, 1.0) | POWER
    return {
        key: (np.array(value) * factor ** powers[key]).tolist() if key in powers else value
        for key, value in table.items()
    }

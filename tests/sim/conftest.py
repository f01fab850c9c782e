"""A State for tests: a body that turns smoothly about all axes and wanders through space."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sim.state import State

FIELD_ENU_nT = np.array([-11484.0, 12637.0, 32731.0])


def make_state(n: int = 2000, interval_s: float = 0.02, seed: int = 0, motors: int = 3) -> State:
    """Two-degree-of-freedom sines about each axis: n samples, with the exact body rate by finite differences."""
    rng = np.random.default_rng(seed)
    t = np.arange(n) * interval_s
    fine = (np.arange(3 * n).reshape(n, 3) // 3 * interval_s) + np.array([-1e-4, 0.0, 1e-4])
    speeds, phases = rng.uniform(0.1, 0.5, 3), rng.uniform(0, 6, 3)
    turn = Rotation.from_euler("ZYX", (np.sin(fine[..., None] * speeds + phases) * 1.4).reshape(-1, 3))
    before, now, after = turn[0::3], turn[1::3], turn[2::3]
    rate = (before.inv() * after).as_rotvec() / 2e-4
    R_wb = np.ascontiguousarray(now.as_matrix())
    field = np.einsum("nij,i->nj", R_wb, FIELD_ENU_nT)
    return State(
        time_s=t,
        interval_s=interval_s,
        pos_enu_m=np.column_stack([np.cos(t / 20), np.sin(t / 30), -t / 500]) * 20.0,
        R_wb=R_wb,
        rate_rad_s=rate,
        field_enu_nT=FIELD_ENU_nT,
        field_nT=field,
        field_rate_nT_s=-np.cross(rate, field),
        temperature_degC=20.0 + 5.0 * np.sin(t / 100.0 + 0.3),
        current_A=2.0 + np.sin(t[:, None] * (1.0 + np.arange(motors))),
    )


def cut_state(state: State, start: int, stop: int) -> State:
    """The samples from start to stop."""
    i = slice(start, stop)
    return State(
        time_s=state.time_s[i],
        interval_s=state.interval_s,
        pos_enu_m=state.pos_enu_m[i],
        R_wb=state.R_wb[i],
        rate_rad_s=state.rate_rad_s[i],
        field_enu_nT=state.field_enu_nT,
        field_nT=state.field_nT[i],
        field_rate_nT_s=state.field_rate_nT_s[i],
        temperature_degC=state.temperature_degC[i],
        current_A=state.current_A[i],
        attitude=state.attitude,
    )


@pytest.fixture(scope="session")
def states() -> Callable[..., State]:
    """`make_state`: states(n, interval_s, seed, motors)."""
    return make_state


@pytest.fixture(scope="session")
def cut() -> Callable[[State, int, int], State]:
    """`cut_state`: cut(state, start, stop)."""
    return cut_state


TURN = [[0.1, 0.01, 0.02], [-0.03, 0.05, 0.03], [0.04, 0.01, 0.02]]
ACTIVE: dict[str, dict[str, object]] = {
    "diurnal_drift": {"amplitude_enu_nT": [10, -20, 30], "period_s": 300, "phase_deg": 40},
    "field_gradient": {"gradient_nT_m": [[1, 2, 3], [2, 1, 4], [3, 4, -2]], "origin_enu_m": [5, 6, 7]},
    "local_dipole": {"position_enu_m": [3, 2, -50], "moment_A_m2": [9e3, 2e3, -4e3], "extent_enu_m": [9, 80, 1]},
    "attitude_misalignment": {"angles_deg": [0.5, -1, 2]},
    "soft_iron": {"matrix": TURN},
    "hard_iron": {"offset_nT": [100, -200, 300]},
    "hard_iron_drift": {"rate_nT_h": [100, -300, 500], "time_constant_s": 100},
    "eddy_current": {"matrix_s": TURN, "time_constant_s": 0.1},
    "motor_current": {"gain_nT_A": [1, -2, 3]},
    "current_ripple": {"amplitude_nT_A": [1, -2, 3], "frequency_hz": 7.3, "phase_deg": 20, "motor": 2},
    "misalignment": {"angles_deg": [1, -2, 3]},
    "non_orthogonality": {"angles_deg": [1, -0.5, 0.7]},
    "scale": {"error": [0.1, -0.05, 0.02]},
    "nonlinearity": {"second_order": [1e-3, 2e-3, -1e-3], "third_order": 2e-3},
    "temperature_scale": {"slope_1_K": [1e-4, 2e-4, -3e-4], "reference_degC": 15},
    "temperature_offset": {"slope_nT_K": [1, -2, 3]},
    "hysteresis": {"gain": [0.02, 0.01, 0.03], "threshold_nT": [200.0, 3000.0]},
    "bandwidth": {"cutoff_hz": 3},
    "sensor_offset": {"offset_nT": [-10, 20, 30]},
    "offset_jump": {"time_s": 10.01, "step_nT": [50, -20, 10]},
    "offset_random_walk": {"std_nT_sqrt_s": 2},
    "flicker_noise": {"density_nT_sqrt_hz": [1, 2, 3]},
    "white_noise": {"std_nT": [5, 6, 7]},
    "latency": {"delay_s": 0.113},
    "saturation": {"full_scale_nT": 25_000},
    "quantisation": {"step_nT": 0.7},
    "spikes": {"rate_hz": 2, "amplitude_nT": 300},
    "dropouts": {"rate_hz": 1, "mean_duration_s": 0.2},
}


@pytest.fixture(scope="session")
def active() -> dict[str, dict[str, object]]:
    """A table for every effect in which it does something."""
    return ACTIVE

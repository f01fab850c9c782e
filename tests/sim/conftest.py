"""A State for tests: a body that turns smoothly about all axes and wanders through space."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from recordings.channels import TEMPERATURE, current_name, currents_of
from scenarios.arrays import Array
from sim.effects import EFFECTS
from sim.state import MOTION, State

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
        channels=_channels(t, motors),
    )


def _channels(t: Array, motors: int) -> dict[str, Array]:
    """Temperature, currents, and something that varies for every other channel that an effect needs."""
    channels = {TEMPERATURE: 20.0 + 5.0 * np.sin(t / 100.0 + 0.3)}
    channels |= currents_of(2.0 + np.sin(t[:, None] * (1.0 + np.arange(motors))))
    needed = {name for cls in EFFECTS for name in cls.needs} - MOTION - {TEMPERATURE, current_name(1)}
    return channels | {name: 1.0 + 0.1 * np.sin(t / 7.0 + len(name)) for name in sorted(needed)}


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
        channels={name: values[i] for name, values in state.channels.items()},
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


@pytest.fixture(scope="session")
def active() -> dict[str, Mapping[str, object]]:
    """A table for every effect in which it does something: its own example."""
    return {cls.name: cls.example for cls in EFFECTS}

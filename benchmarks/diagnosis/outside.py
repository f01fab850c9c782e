"""Disturbances that no effect of the library makes, each with the channel that drives it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from benchmarks.diagnosis.truth import beyond_base
from recordings import Recording
from scenarios.arrays import Array
from sim.state import State

Course = Callable[[np.random.Generator, Recording, State], tuple[Array, Array]]
"""(rng, recording, state) -> the driver (n,) as it is logged, and the disturbance's course (n,) or (n, 3)."""


def _pump(rng: np.random.Generator, recording: Recording, state: State) -> tuple[Array, Array]:
    """A pump that runs now and then, logged as a channel of its own; its field rises with a lag of a second."""
    n, step = len(state), state.interval_s
    switches = np.cumsum(rng.exponential(25.0, 400))
    on = (np.searchsorted(switches, state.time_s) % 2).astype(float)
    course = np.zeros(n)
    for k in range(1, n):
        course[k] = course[k - 1] + (on[k] - course[k - 1]) * min(1.0, step / 1.0)
    return on, course


def _spin(rng: np.random.Generator, recording: Recording, state: State) -> tuple[Array, Array]:
    """A wheel's speed squared."""
    speed = np.sin(2 * np.pi * state.time_s / 47.0) + 0.5 * np.sin(2 * np.pi * state.time_s / 19.0 + 1)
    return speed, speed**2


def _pressure(rng: np.random.Generator, recording: Recording, state: State) -> tuple[Array, Array]:
    """Stress in the hull with the square root of depth or height."""
    up = state.pos_enu_m[:, 2]
    return up, np.sqrt(np.abs(up - up.mean()))


def _swing(rng: np.random.Generator, recording: Recording, state: State) -> tuple[Array, Array]:
    """A loose part that follows the heading in four lobes."""
    heading = _heading_rad(state)
    return heading, np.sin(4 * heading)


def _heading_rad(state: State) -> Array:
    return np.asarray(np.arctan2(state.R_wb[:, 1, 0], state.R_wb[:, 0, 0]))


def _turning(rng: np.random.Generator, recording: Recording, state: State) -> tuple[Array, Array]:
    """A gyro's drive that disturbs with the size of the turn's rate."""
    rate = state.rate_rad_s[:, 2]
    return rate, np.abs(rate)


def _load(rng: np.random.Generator, recording: Recording, state: State) -> tuple[Array, Array]:
    """A motor's lead that swings with the heading: its field goes with the current and three lobes of that."""
    current = state.current_A[:, 0]
    return current, current * np.sin(3 * _heading_rad(state))


OUTSIDE: dict[str, tuple[Course, tuple[str, ...]]] = {
    "pump": (_pump, ("pump",)),
    "wheel": (_spin, ("wheel",)),
    "pressure": (_pressure, ("pos_up_m",)),
    "loose_part": (_swing, ("heading",)),
    "gyro_drive": (_turning, ("rate_z",)),
    "loose_lead": (_load, ("current_1_A",)),
}
"""name -> (course, the channels that drive it)."""
LOGGED = ("pump", "wheel")
"""Those whose driver is a channel of its own."""


def disturbed(name: str, strength: float, seed: int, recording: Recording, state: State, mag_nT: Array) -> Recording:
    """The recording with a disturbance from outside the library at a strength, and its channel where it has one."""
    rng = np.random.default_rng([seed, 11])
    driver, course = OUTSIDE[name][0](rng, recording, state)
    added = course[:, None] * rng.normal(size=3)
    added *= strength / beyond_base(state.field_nT + added, state.field_nT)
    channels = {name: driver} if name in LOGGED else {}
    return replace(recording, mag_nT=mag_nT + added, channels={**recording.channels, **channels})

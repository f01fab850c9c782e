"""Recordings of an analytic motion, without an engine: a turn about all axes, a track, a current, a temperature."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from diagnosis.policy import STANDARD, Policy
from diagnosis.problem.formulation import pose
from diagnosis.problem.known import Known
from diagnosis.problem.linear import LinearProblem
from recordings import Recording
from recordings.columns import group_of
from scenarios.arrays import Array
from sim import effects as effect_table
from sim.chain import Chain
from sim.effects.base import Effect
from sim.effects.registry import EFFECTS
from sim.state import MOTION

FIELD_ENU_NT = np.array([1_000.0, 20_000.0, -43_000.0])
STRENGTH_NT = float(np.linalg.norm(FIELD_ENU_NT))
NOISE_NT = 2.0
HZ = 10.0
CAUSES = {name for effect in EFFECTS for name in effect.needs} - MOTION
OTHER_CAUSES = sorted(name for name in CAUSES if group_of(name) == "channel")
"""What effects depend on beside what every recording may hold."""
COSTLY = frozenset(effect.name for effect in EFFECTS if effect.with_role("place", "period"))
"""Effects sought by their place or their period, a third of the work: left out where a test asks for no name of these.

`test_workflow.py` hides effects beside the whole library.
"""
ALL_BUT_SEVEN = frozenset(effect.name for effect in EFFECTS) - {
    "motor_current",
    "current_ripple",
    "hysteresis",
    "nonlinearity",
    "offset_jump",
    "regional_field",
    "temperature_offset",
}
"""Left out where seven effects are enough for a wrong name."""


def recording(
    n: int = 4000, *, seed: int = 0, noise_nT: float = NOISE_NT, hidden: dict[str, Any] | None = None
) -> Recording:
    """n samples at 10 Hz, white noise on every axis, with effects (tables) in the magnetometer."""
    t = np.arange(n) / HZ
    turn = Rotation.from_euler("ZYX", np.column_stack([0.13 * t, 0.5 * np.sin(0.17 * t), 0.6 * np.sin(0.11 * t)]))
    made = Recording(
        time_s=t,
        mag_nT=turn.inv().apply(FIELD_ENU_NT),
        att_q=turn.as_quat()[:, [3, 0, 1, 2]],
        pos_enu_m=np.column_stack([20 * np.sin(0.05 * t), 20 * np.cos(0.07 * t), -3 + 2 * np.sin(0.03 * t)]),
        temperature_degC=15 + 3 * np.sin(0.013 * t) ** 2,
        current_A=np.column_stack([2 + np.sin(0.31 * t), 1 + 0.5 * np.cos(0.47 * t) ** 3]),
        channels={name: np.sin(0.23 * t + k) ** 2 for k, name in enumerate(OTHER_CAUSES)},
    )
    state = pose(made, Known(FIELD_ENU_NT, STRENGTH_NT)).state
    tables = {"white_noise": {"std_nT": [noise_nT] * 3}, **(hidden or {})}
    return _with(made, Chain(effect_table.build(tables, None, "test"), seed).apply(state)[0])


def problem(
    given: Recording | None = None, model: tuple[Effect, ...] = (), policy: Policy = STANDARD, **made: Any
) -> LinearProblem:
    """The problem that a recording and a model pose; made by `recording` if none is given."""
    return pose(recording(**made) if given is None else given, Known(FIELD_ENU_NT, STRENGTH_NT, model, policy))


def without_attitude(given: Recording) -> Recording:
    """The same, of which only the field's strength can be compared."""
    return _with(given, given.mag_nT, att_q=None)


def _with(given: Recording, mag_nT: Array, **changes: Any) -> Recording:
    return replace(given, mag_nT=np.asarray(mag_nT), **changes)

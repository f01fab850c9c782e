"""Problem of a recording without heading: the strength of the field is compared, with a level the dip as well."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from calib.numerics.rates import body_rate
from diagnosis.policy import Policy
from diagnosis.problem.iron_fit import LEAST_LEVEL, compared, fit_iron
from diagnosis.problem.linear import LinearProblem, about_model_effects
from diagnosis.problem.motion import FieldTrack, Level, measured, noise_of_neighbours, state_of
from diagnosis.problem.sensors import measured_strength
from recordings import Recording
from scenarios.arrays import Array
from sim.effects.base import Effect
from sim.state import State
from validation.signals.direction_rate import median_rate_rad_s

TURN_STEP_S = 0.04
"""Time step of the turn rate: short beside a wheel's turn, long beside the noise of a hand-held sensor."""


def strength_problem(
    recording: Recording,
    field_enu_nT: Array,
    effects: tuple[Effect, ...],
    policy: Policy,
    track: FieldTrack | None = None,
    level: Level | None = None,
    disturbance_nT: Array | float = 0.0,
) -> LinearProblem:
    """The problem of the strength, see `LinearProblem`, with iron fitted after a known disturbance is subtracted.

    With the part d (n, 3) of the measurement m subtracted, ``h = M (m - d - o)`` and ``u = h / |h|``; ``y = |h| - F + u
    M d``, to first order independent of d, so that effects and iron are estimated jointly by iteration. A recorded
    scalar magnetometer, which must be compensated, replaces the given F sample by sample. With a level the dip is
    compared as well: ``F (dip(h) - I) + v M d``, v the direction across u of increasing dip. The model's effects other
    than iron are subtracted from m first. field_enu_nT (3,): the given field, in any direction if none is known.
    """
    strength_nT, F_nT = float(np.linalg.norm(field_enu_nT)), measured_strength(recording)
    if F_nT is None:
        F_nT = np.full((len(recording), 1), strength_nT) + (0.0 if track is None else track.change_nT[:, None])
    middle_nT = field_enu_nT * (float(np.median(F_nT)) / strength_nT if track is None else 1.0)
    pose = partial(_about_iron, recording, F_nT, middle_nT, disturbance_nT, level, effects, policy)
    return replace(about_model_effects(pose), track=track, level=level)


def _about_iron(
    recording: Recording,
    F_nT: Array,
    middle_nT: Array,
    disturbance_nT: Array | float,
    level: Level | None,
    effects: tuple[Effect, ...],
    policy: Policy,
    beyond_nT: Array | float,
) -> LinearProblem:
    """The problem of strengths (n, 1), iron fitted to the measurement less a disturbance and the effects beyond iron.

    middle_nT (3,): the field east, north, up in the middle.
    """
    mag_nT = recording.mag_nT - beyond_nT - disturbance_nT
    iron = fit_iron(mag_nT, F_nT[:, 0], recording.time_s, policy, level)
    output_axes, off_nT = compared(iron.field_nT(mag_nT), F_nT, level)
    off_nT[:, 1:] -= F_nT * np.median(off_nT[:, 1:] / F_nT, axis=0)  # the dip is known but for a constant
    sigma, field_nT = _noise_nT(off_nT, recording, policy), output_axes[:, 0] * F_nT
    disturbed_nT = (recording.mag_nT - beyond_nT - mag_nT) @ iron.matrix.T
    clean_nT = iron.measured_nT(field_nT) + beyond_nT
    return LinearProblem(
        recording=recording,
        state=_state(recording, field_nT, middle_nT, level),
        effects=effects,
        base=strength_columns(output_axes[:, 0]) if level is None else dip_columns(output_axes) / sigma[:, None],
        target=(off_nT + np.einsum("nqi,ni->nq", output_axes, disturbed_nT)) / sigma,
        sigma_nT=sigma,
        usable=np.ones(len(recording)),
        turn=iron.turn,
        clean_nT=clean_nT,
        predicted_nT=clean_nT,
        inputs=measured(recording) | {"rate"},  # of the field that is measured
        policy=policy,
        output_axes=output_axes,
        beyond_nT=beyond_nT,
    )


def _noise_nT(off_nT: Array, recording: Recording, policy: Policy) -> Array:
    """Noise of a sample (q,) of each deviation (n, q)."""
    each = [noise_of_neighbours(off[:, None], recording.mag_nT, recording.time_s, policy) for off in off_nT.T]
    return np.concatenate(each)


def strength_columns(direction: Array) -> Array:
    """Derivatives (n, 9) of the strength by a symmetric matrix and an offset, along unit directions (n, 3)."""
    pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]
    return np.column_stack([*(direction[:, i] * direction[:, j] for i, j in pairs), direction])


def dip_columns(output_axes: Array) -> Array:
    """Derivatives (n, 2, 13) of strength and dip by a matrix, an offset, and a constant error of the given dip.

    output_axes (n, 2, 3): unit directions of the field, and of increasing dip. The outputs share the coefficients.
    """
    n, q, _ = output_axes.shape
    elements = (output_axes[:, :, :, None] * output_axes[:, :1, None, :]).reshape(n, q, 9)
    constant = np.tile([[0.0], [1.0]], (n, 1, 1))
    return np.concatenate([elements, output_axes, constant], axis=2)


def _state(recording: Recording, field_nT: Array, field_enu_nT: Array, level: Level | None) -> State:
    """The state with attitudes that turn a measured field (n, 3) to the given one, and, with a level, down to down.

    Without a level the turn about the field is unknown and any.
    """
    down, down_enu = (np.eye(3)[np.abs(field).argmin(axis=1)] for field in (field_nT, field_enu_nT[None]))
    if level is not None:
        down, down_enu = level.down, np.array([[0.0, 0.0, -1.0]])
    R_wb = _axes(field_enu_nT[None], down_enu).transpose(0, 2, 1) @ _axes(field_nT, down)
    return state_of(recording, field_enu_nT, field_nT, body_rate(recording), R_wb=R_wb)


def _axes(field: Array, second: Array) -> Array:
    """Right-handed unit vectors (n, 3, 3), as rows: along fields (n, 3), and towards second vectors."""
    first = field / np.linalg.norm(field, axis=1, keepdims=True)
    third = np.cross(first, second)
    third /= np.maximum(np.linalg.norm(third, axis=1, keepdims=True), LEAST_LEVEL)
    return np.stack([first, np.cross(third, first), third], axis=1)


def turn_rate_rad_s(problem: LinearProblem) -> float:
    """Median turn rate of the measured field in sensor axes, over a time step that suppresses noise."""
    u = (problem.recording.mag_nT - problem.beyond_nT - problem.offset_nT) @ np.linalg.inv(problem.turn).T
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    return median_rate_rad_s(u, problem.state.time_s, TURN_STEP_S)


def turns_too_fast(problem: LinearProblem) -> bool:
    """Whether the field, assumed constant in a turning sensor without a logged turn, turns faster than any vehicle."""
    unseen = problem.mode == "strength" and problem.recording.gyro_rad_s is None and problem.recording.att_q is None
    return unseen and turn_rate_rad_s(problem) > problem.policy.fastest_turn

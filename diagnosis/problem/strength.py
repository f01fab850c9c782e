"""Problem of a recording without heading: the strength of the field is compared, with a level the dip as well."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from calib.numerics.rates import body_rate, smoothed_derivative
from diagnosis.policy import Policy
from diagnosis.problem.iron_fit import fit_iron
from diagnosis.problem.level import LEAST_LEVEL, Dip, Level, dip_rad, upright
from diagnosis.problem.linear import LinearProblem
from diagnosis.problem.model_effects import pose_without_model_effects
from diagnosis.problem.rates import course, measured
from diagnosis.problem.repeated_rows import noise_of_neighbours
from diagnosis.problem.track import FieldTrack
from recordings import Recording
from recordings.channels import SCALAR
from scenarios.arrays import Array
from scenarios.errors import InputError
from sim.effects.base import Effect
from sim.rotation import cross
from sim.state import State
from validation.signals.direction_rate import median_rate_rad_s

TURN_STEP_S = 0.04
"""Time step of the turn rate: short beside a wheel's turn, long beside the noise of a hand-held sensor."""


def strength_problem(
    recording: Recording,
    strength_nT: float,
    effects: tuple[Effect, ...],
    policy: Policy,
    disturbance_nT: Array | None = None,
    track: FieldTrack | None = None,
    level: Level | None = None,
    field_enu_nT: Array | None = None,
) -> LinearProblem:
    """The problem of the strength, see `LinearProblem`, with iron fitted after a known disturbance is subtracted.

    With the part d (n, 3) of the measurement m subtracted, ``h = M (m - d - o)`` and ``u = h / |h|``; ``y = |h| - F + u
    M d``, to first order independent of d, so that effects and iron are estimated jointly by iteration. A recorded
    scalar magnetometer, which must be compensated, replaces the given F sample by sample. With a level the dip is
    compared as well: ``F (dip(h) - I) + v M d``, v the direction across u of increasing dip. The model's effects other
    than iron are subtracted from m first. field_enu_nT (3,): the given field where its direction is known.
    """
    given_nT = field_enu_nT if level is None else level.field_enu_nT
    known_nT = 0.0 if disturbance_nT is None else disturbance_nT
    reference = _Reference(strength_nT, _direction(given_nT), track, level)
    return pose_without_model_effects(lambda seen: _posed(seen, reference, known_nT, policy), recording, effects)


class _Reference(NamedTuple):
    """What is known of the field: its strength in nT, direction (3,), change along a track, and the level."""

    strength_nT: float
    direction: Array
    track: FieldTrack | None
    level: Level | None


def _posed(recording: Recording, reference: _Reference, known_nT: Array | float, policy: Policy) -> LinearProblem:
    """The problem with iron fitted to the measurement less a known disturbance (n, 3)."""
    track, level = reference.track, reference.level
    F, mag_nT = _strength(recording, reference.strength_nT, track), recording.mag_nT - known_nT
    dip = None if level is None else level.dip(track)
    iron = fit_iron(mag_nT, F[:, 0], _block(recording, policy), policy, dip)
    output_axes, deviation = _compared(iron.field_nT(mag_nT), F, dip)
    sigma = _noise_nT(deviation, recording, policy)
    residual = deviation + np.einsum("nqi,ni->nq", output_axes, (recording.mag_nT - mag_nT) @ iron.matrix.T)
    middle_nT = float(np.median(F)) if track is None else reference.strength_nT
    state = _state(recording, output_axes[:, 0] * F, middle_nT * reference.direction, dip)
    clean = iron.measured_nT(state.field_nT)
    return LinearProblem(
        recording=recording,
        state=state,
        effects=(),
        mode="strength",
        base=_base(output_axes, sigma),
        target=residual / sigma,
        sigma_nT=sigma,
        usable=np.ones(len(recording)),
        turn=iron.turn,
        clean_nT=clean,
        predicted_nT=clean,
        inputs=measured(recording) | {"rate"},  # of the field that is measured
        policy=policy,
        track=track,
        level=level,
        output_axes=output_axes,
    )


def _block(recording: Recording, policy: Policy) -> int:
    """Samples of a block."""
    return max(1, round(policy.block_s / float(np.median(np.diff(recording.time_s)))))


def _compared(field_nT: Array, F: Array, dip: Dip | None) -> tuple[Array, Array]:
    """Directions (n, q, 3) of strength and dip of a field (n, 3), and their residuals (n, q) in nT."""
    size = np.linalg.norm(field_nT, axis=1, keepdims=True)
    direction = field_nT / size
    if dip is None:
        return direction[:, None], np.asarray(size - F)
    off_rad = dip_rad(field_nT, dip.down) - dip.given_rad
    dip_nT = F[:, 0] * (off_rad - np.median(off_rad))
    return np.stack([direction, upright(direction, dip.down)], axis=1), np.column_stack([size - F, dip_nT])


def _noise_nT(left_nT: Array, recording: Recording, policy: Policy) -> Array:
    """Noise of a sample (q,) of each residual (n, q)."""
    each = (noise_of_neighbours(column[:, None], recording.mag_nT, recording.time_s, policy) for column in left_nT.T)
    return np.concatenate(list(each))


def _direction(field_enu_nT: Array | None) -> Array:
    """Direction (3,) of a given field; north where the strength alone is known."""
    return np.array([0.0, 1.0, 0.0]) if field_enu_nT is None else field_enu_nT / np.linalg.norm(field_enu_nT)


def _strength(recording: Recording, given_nT: float, track: FieldTrack | None) -> Array:
    """Strength (n, 1) in nT: measured, or given with its change along a track."""
    measured_nT = measured_strength(recording)
    if measured_nT is not None:
        return measured_nT
    return np.full((len(recording), 1), given_nT) + (0.0 if track is None else track.change_nT[:, None])


def measured_strength(recording: Recording) -> Array | None:
    """Strength (n, 1) in nT of a recorded scalar magnetometer, None without complete values.

    Raises InputError for values that are not positive.
    """
    known_nT = recording.channels.get(SCALAR)
    if known_nT is None or not np.isfinite(known_nT).all():
        return None
    if known_nT.min() <= 0:
        what = f"{SCALAR} is the strength of a field in nT, found {known_nT.min():g}"
        raise InputError(what, where="recording", do="give it another name if it is something else")
    return known_nT[:, None]


def turn_rate_rad_s(problem: LinearProblem) -> float:
    """Median turn rate of the measured field in sensor axes, over a time step that suppresses noise."""
    known_nT = problem.recording.mag_nT + (problem.state.field_nT[0] @ problem.turn.T - problem.clean_nT[0])
    u = known_nT @ np.asarray(np.linalg.inv(problem.turn), dtype=np.float64).T
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    return median_rate_rad_s(u, problem.state.time_s, TURN_STEP_S)


def turns_too_fast(problem: LinearProblem) -> bool:
    """Whether the field, assumed constant in a turning sensor without a logged turn, turns faster than any vehicle."""
    unseen = problem.mode == "strength" and problem.recording.gyro_rad_s is None and problem.recording.att_q is None
    return unseen and turn_rate_rad_s(problem) > problem.policy.fastest_turn


def refit_iron(problem: LinearProblem, disturbance_nT: Array) -> LinearProblem:
    """A strength problem with iron fitted after a disturbance (n, 3) of the measurement is subtracted."""
    strength_nT = float(np.linalg.norm(problem.state.field_enu_nT))
    anew = strength_problem(
        problem.recording,
        strength_nT,
        problem.effects,
        problem.policy,
        disturbance_nT,
        problem.track,
        problem.level,
        problem.state.field_enu_nT,
    )
    state = replace(anew.state, channels=problem.state.channels)
    std_rad, done = problem.attitude_std_rad, problem.corrections
    kept = replace(anew, state=state, attitude_std_rad=std_rad, corrections=done, **problem.findings)
    return kept.without(problem.usable == 0)


def strength_columns(direction: Array) -> Array:
    """Derivatives (n, 9) of the strength by a symmetric matrix and an offset, along unit directions (n, 3)."""
    pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]
    return np.column_stack([*(direction[:, i] * direction[:, j] for i, j in pairs), direction])


def _base(output_axes: Array, sigma: Array) -> Array:
    """Base (n, 9) of the strength, or (n, 2, 13) of strength and dip, along directions (n, q, 3)."""
    return (
        strength_columns(output_axes[:, 0]) if output_axes.shape[1] == 1 else dip_columns(output_axes) / sigma[:, None]
    )


def dip_columns(output_axes: Array) -> Array:
    """Derivatives (n, 2, 13) of strength and dip by a matrix, an offset, and a constant error of the given dip.

    output_axes (n, 2, 3): unit directions of the field, and of increasing dip. The outputs share the coefficients.
    """
    n, q, _ = output_axes.shape
    elements = (output_axes[:, :, :, None] * output_axes[:, :1, None, :]).reshape(n, q, 9)
    constant = np.tile([[0.0], [1.0]], (n, 1, 1))
    return np.concatenate([elements, output_axes, constant], axis=2)


def _state(recording: Recording, field: Array, field_enu_nT: Array, dip: Dip | None) -> State:
    rate = body_rate(recording)
    return State(
        R_wb=_attitude(field, field_enu_nT, dip),
        rate_rad_s=np.zeros_like(field) if rate is None else rate,
        field_enu_nT=field_enu_nT,
        field_nT=field,
        field_rate_nT_s=smoothed_derivative(field, recording.time_s) if rate is None else -cross(rate, field),
        **course(recording),
    )


def _attitude(field_nT: Array, field_enu_nT: Array, dip: Dip | None) -> Array:
    """Attitudes (n, 3, 3) that turn a measured field (n, 3) to the given one, and, with a dip, down towards down.

    Without a dip the turn about the field is unknown and any: of a field in the Earth's axes the strength shows only
    the part along the given field.
    """
    down = _across(field_nT) if dip is None else dip.down
    down_enu = _across(field_enu_nT[None]) if dip is None else np.array([[0.0, 0.0, -1.0]])
    here, there = (_axes(*pair) for pair in ((field_nT, down), (field_enu_nT[None], down_enu)))
    return np.asarray(there.transpose(0, 2, 1) @ here)


def _across(field: Array) -> Array:
    """Vectors (n, 3) that are not along fields (n, 3): the axis on which each has least."""
    return np.asarray(np.eye(3)[np.abs(field).argmin(axis=1)])


def _axes(field: Array, second: Array) -> Array:
    """Right-handed unit vectors (n, 3, 3), as rows: along fields (n, 3), and towards second vectors."""
    first = field / np.linalg.norm(field, axis=1, keepdims=True)
    third = np.cross(first, second)
    third /= np.maximum(np.linalg.norm(third, axis=1, keepdims=True), LEAST_LEVEL)
    return np.stack([first, np.cross(third, first), third], axis=1)

"""The problem of a recording without attitude: only the field's strength is compared."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from calib.numerics.rates import body_rate, smoothed_derivative
from scenarios.errors import InputError
from sim.dataset import Recording
from sim.effects.base import Effect
from sim.rotation import cross
from sim.state import SCALAR, Array, State
from validation.diagnosis.policy import Policy
from validation.diagnosis.problem.held import noise_of_neighbours
from validation.diagnosis.problem.iron_by_strength import Iron, fitted_iron
from validation.diagnosis.problem.linear import LinearProblem
from validation.diagnosis.problem.motion import course, measured
from validation.diagnosis.problem.track import Track


def strength_problem(
    recording: Recording,
    strength_nT: float,
    effects: tuple[Effect, ...],
    policy: Policy,
    disturbance_nT: Array | None = None,
    track: Track | None = None,
) -> LinearProblem:
    """The problem of the strength, see `LinearProblem`, about iron fitted beside a known part of the disturbance.

    With the part d (n, 3) of the measurement m out, ``h = M (m - d - o)`` and ``u = h / |h|``; y is
    ``|h| - F + u M d``: the same to first order wherever d is, so that effects and iron are found jointly in steps. A
    scalar magnetometer beside it is the strength F sample by sample, whatever was given: it must be compensated.
    """
    F = _strength(recording, strength_nT, track)
    known = np.zeros((len(recording), 3)) if disturbance_nT is None else disturbance_nT
    iron = _iron(recording, known, F[:, 0], policy)
    direction, size = _direction_and_size(iron.field_nT(recording.mag_nT - known))
    sigma = noise_of_neighbours(size - F, recording.mag_nT, recording.time_s, policy)
    residual = size - F + np.einsum("ni,ni->n", direction, known @ iron.matrix)[:, None]
    turn = _inverse(iron.matrix)
    state = _state(recording, direction * F, float(np.median(F)) if track is None else strength_nT)
    clean = state.field_nT @ turn.T + iron.offset_nT
    return LinearProblem(
        recording=recording,
        state=state,
        effects=effects,
        mode="strength",
        base=strength_columns(direction),
        target=residual / sigma,
        sigma_nT=sigma,
        usable=np.ones(len(recording)),
        turn=turn,
        clean_nT=clean,
        predicted_nT=clean,
        has=measured(recording) | {"rate"},  # of the field that is measured
        policy=policy,
        track=track,
    )


def _inverse(matrix: Array) -> Array:
    return np.asarray(np.linalg.inv(matrix), dtype=np.float64)


def _direction_and_size(field_nT: Array) -> tuple[Array, Array]:
    """Unit vectors (n, 3) and sizes (n, 1)."""
    size = np.linalg.norm(field_nT, axis=1, keepdims=True)
    return field_nT / size, np.asarray(size)


def _strength(recording: Recording, given_nT: float, track: Track | None) -> Array:
    """The field's strength (n, 1) in nT: measured, or as given, with its change along a track."""
    measured_nT = measured_strength(recording)
    if measured_nT is not None:
        return measured_nT
    return np.full((len(recording), 1), given_nT) + (0.0 if track is None else track.change_nT[:, None])


def measured_strength(recording: Recording) -> Array | None:
    """The field's strength (n, 1) in nT by a scalar magnetometer beside the vector one, where all its values are known.

    Raises InputError for one that is no strength of a field.
    """
    known_nT = recording.channels.get(SCALAR)
    if known_nT is None or not np.isfinite(known_nT).all():
        return None
    if known_nT.min() <= 0:
        what = f"{SCALAR} is the strength of a field in nT, found {known_nT.min():g}"
        raise InputError(what, where="recording", do="give it another name if it is something else")
    return known_nT[:, None]


def about(problem: LinearProblem, disturbance_nT: Array) -> LinearProblem:
    """A strength problem about iron that was fitted with a disturbance (n, 3) of the measurement out."""
    strength_nT = float(np.linalg.norm(problem.state.field_enu_nT))
    anew = strength_problem(
        problem.recording, strength_nT, problem.effects, problem.policy, disturbance_nT, problem.track
    )
    state = replace(anew.state, channels=problem.state.channels)
    std_rad, known = problem.attitude_std_rad, problem.iron_known
    kept = replace(anew, state=state, attitude_std_rad=std_rad, iron_known=known, instead=problem.instead)
    return kept.without(problem.usable == 0)


def _iron(recording: Recording, known_nT: Array, strength_nT: Array, policy: Policy) -> Iron:
    interval_s = float(np.median(np.diff(recording.time_s)))
    block = max(1, round(policy.block_s / interval_s))
    return fitted_iron(recording.mag_nT - known_nT, strength_nT, block, policy)


def strength_columns(direction: Array) -> Array:
    """Changes (n, 9) of the strength with a symmetric matrix and an offset, along unit directions (n, 3)."""
    pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]
    return np.column_stack([*(direction[:, i] * direction[:, j] for i, j in pairs), direction])


def _state(recording: Recording, field: Array, strength_nT: float) -> State:
    n = len(recording)
    rate = body_rate(recording)
    return State(
        R_wb=np.tile(np.eye(3), (n, 1, 1)),
        rate_rad_s=np.zeros((n, 3)) if rate is None else rate,
        field_enu_nT=np.array([0.0, strength_nT, 0.0]),
        field_nT=field,
        field_rate_nT_s=smoothed_derivative(field, recording.time_s) if rate is None else -cross(rate, field),
        **course(recording),
    )

"""Problem of a recording with attitude: every axis is compared."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from diagnosis.policy import Policy
from diagnosis.problem.linear import LinearProblem
from diagnosis.problem.model_effects import beyond_iron_nT
from diagnosis.problem.rates import course, measured, quieter_rate
from diagnosis.problem.repeated_rows import held, noise_of_neighbours
from diagnosis.problem.track import FieldTrack
from diagnosis.problem.vehicle_iron import fitted_iron
from recordings import Recording
from scenarios.arrays import Array
from sim.chain import apply_deterministic
from sim.effects.base import Effect
from sim.effects.chain_position import insert_effects, iron_matrix
from sim.rotation import cross, matrix_from_q, to_body
from sim.state import State

FIELD_ERROR, DELAY_S = 0.02, 0.1
"""Standard deviations of a given field's relative error and of the delay against the attitude: priors where the
motion does not determine them.
"""
STEPS = 3
"""Steps to the matrix, and to the model's effects behind it: each squares the error of the preceding step."""


def vector_problem(
    recording: Recording,
    field_enu_nT: Array,
    effects: tuple[Effect, ...],
    policy: Policy,
    track: FieldTrack | None = None,
) -> LinearProblem:
    """The problem of the three axes, see `LinearProblem`, for a recording with attitude.

    The model's effects beyond iron are subtracted, each behind the fitted iron: a free matrix on the whole prediction
    would span a motor's field in the body frame and take a wrong gain for iron.
    """
    state = motion_of(recording, field_enu_nT, policy, track)
    smooth = [effect for effect in effects if not effect.traits.converter]
    beyond_nT = beyond_iron_nT(smooth, state)
    problem = _posed(recording, state, effects, beyond_nT, policy, track)
    for _ in range(STEPS if beyond_nT.any() else 0):
        beyond_nT = beyond_iron_nT(insert_effects(smooth, fitted_iron(problem)), state)
        problem = _posed(recording, state, effects, beyond_nT, policy, track)
    return problem


def _posed(
    recording: Recording,
    state: State,
    effects: tuple[Effect, ...],
    beyond_nT: Array,
    policy: Policy,
    track: FieldTrack | None,
) -> LinearProblem:
    """The problem with iron fitted to the recording less the contribution (n, 3) of the model's effects beyond iron."""
    iron_nT, _ = apply_deterministic([effect for effect in effects if effect.traits.absorbed], state)
    base = np.column_stack([iron_nT / np.linalg.norm(state.field_enu_nT), np.ones(len(recording))])
    mag_nT = recording.mag_nT - beyond_nT
    clean = base @ robust_fit(base, mag_nT, policy)
    fresh = ~held(recording.mag_nT, mag_nT - clean, policy)
    if not fresh.all():
        clean = base @ robust_fit(base[fresh], mag_nT[fresh], policy)
    residual = mag_nT - clean
    sigma = noise_of_neighbours(residual, recording.mag_nT, state.time_s, policy)
    return LinearProblem(
        recording=recording,
        state=state,
        effects=effects,
        mode="vector",
        base=base,
        target=residual / sigma,
        sigma_nT=sigma,
        usable=np.ones(len(recording)),
        turn=_turn(state, base, clean, residual, sigma),
        clean_nT=clean + beyond_nT,
        predicted_nT=apply_deterministic(effects, state)[0],
        inputs=measured(recording),
        policy=policy,
        track=track,
        beyond_nT=beyond_nT,
    )


def motion_of(recording: Recording, field_enu_nT: Array, policy: Policy, track: FieldTrack | None) -> State:
    """State of the recorded motion, ``dT/dt = R^T dF/dt - w x T``, F the field along the track."""
    assert recording.att_q is not None
    rate = quieter_rate(recording, policy)
    R_wb = matrix_from_q(np.ascontiguousarray(recording.att_q))
    change = np.zeros((len(recording), 3)) if track is None else track.change_enu_nT
    field = to_body(R_wb, field_enu_nT + change)
    on_the_way = to_body(R_wb, np.gradient(change, recording.time_s, axis=0))
    return State(
        R_wb=R_wb,
        rate_rad_s=rate,
        field_enu_nT=field_enu_nT,
        field_nT=field,
        field_rate_nT_s=on_the_way - cross(rate, field),
        **course(recording),
    )


def _turn(state: State, base: Array, clean: Array, residual: Array, sigma: Array, least_rad: float = 0.0) -> Array:
    """Matrix (3, 3) from the undisturbed to the measured field, estimated with a field error c and a delay d.

    ``M (R^T (F + c) + d dT/dt) + b``, T the field in the body frame, is fitted in steps linear in M, b, c and d;
    without c and d the matrix would absorb them. Priors hold c and d at zero where the motion does not determine them:
    FIELD_ERROR of the field's strength and DELAY_S; `least_rad`: an attitude error that c must exceed.
    """
    turn = fit_matrix(state.field_nT, clean)
    Q = np.linalg.qr(base / np.linalg.norm(base, axis=0))[0]
    prior = np.diag(np.r_[np.full(3, FIELD_ERROR * np.linalg.norm(state.field_enu_nT)), DELAY_S] ** -2.0)
    prior[:3, :3] += np.eye(3) * len(base) * (least_rad**2 / sigma**2).sum()
    errors = np.concatenate([state.R_wb.transpose(0, 2, 1), state.field_rate_nT_s[:, :, None]], axis=2)
    for _ in range(STEPS):
        E = turn @ errors
        orthogonal = (E - np.einsum("np,pqk->nqk", Q, np.einsum("np,nqk->pqk", Q, E))) / sigma[:, None]
        flat = orthogonal.reshape(-1, errors.shape[2])
        c = np.linalg.lstsq(flat.T @ flat + prior, flat.T @ (residual / sigma).ravel(), rcond=1e-12)[0]
        turn = fit_matrix(state.field_nT, clean - Q @ (Q.T @ (E @ c)))
    return turn


def with_attitude_std(problem: LinearProblem, attitude_std_rad: float) -> LinearProblem:
    """The problem of a model that states an attitude error of navigation, one standard deviation in rad.

    The attitude error biases the matrix where the field varies little more: along such directions the model's matrix
    holds.
    """
    stated = replace(problem, attitude_std_rad=attitude_std_rad)
    if attitude_std_rad == 0 or not problem.turns:
        return stated
    least_rad, state = problem.policy.tenfold * attitude_std_rad, problem.state
    left_nT = problem.target * problem.sigma_nT
    turn = _turn(state, problem.base, problem.clean_nT - problem.beyond_nT, left_nT, problem.sigma_nT, least_rad)
    values, directions = np.linalg.eigh(np.cov(state.field_nT.T))
    hidden = directions[:, values < (least_rad * np.linalg.norm(state.field_enu_nT)) ** 2]
    return replace(stated, turn=turn + (iron_matrix(problem.effects, state) - turn) @ hidden @ hidden.T)


def fit_matrix(field: Array, clean: Array) -> Array:
    """Matrix (3, 3) from the undisturbed field (n, 3) to the predicted measurement (n, 3): least squares."""
    design = np.column_stack([field, np.full(len(field), np.linalg.norm(field[0]))])
    return np.asarray(np.linalg.lstsq(design, clean, rcond=1e-6)[0][:3].T)


def robust_fit(base: Array, mag_nT: Array, policy: Policy) -> Array:
    """Least squares (p, q), repeated once without outliers, so that rare failures do not determine the base."""
    beta = np.linalg.lstsq(base, mag_nT, rcond=None)[0]
    off = np.abs(mag_nT - base @ beta)
    far = (off > policy.never_sigma * np.maximum(np.median(off, axis=0), 1e-9)).any(axis=1)
    if 0 < np.count_nonzero(far) < policy.fair_share * len(far):
        beta = np.linalg.lstsq(base[~far], mag_nT[~far], rcond=None)[0]
    return np.asarray(beta)

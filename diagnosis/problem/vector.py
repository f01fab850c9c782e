"""Problems of three axes: of a recording with attitude, of a sensor at rest, of a sensor beside a reference sensor."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from calib.numerics.rates import body_rate, smoothed_derivative
from diagnosis.policy import Policy
from diagnosis.problem.given_field import FieldTrack
from diagnosis.problem.linear import IN_EARTH_FRAME, LinearProblem, held, noise_of_neighbours, sample_noise
from diagnosis.problem.model_effects import beyond_iron_nT, fitted_iron, pose_without_model_effects
from diagnosis.problem.motion import measured, motion_of, state_of
from recordings import Recording
from recordings.channels import REFERENCE
from scenarios.arrays import Array
from sim.chain import apply_deterministic
from sim.effects.base import Effect
from sim.effects.chain_position import insert_effects, iron_matrix, without_iron
from sim.rotation import cross
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
    iron_nT, predicted_nT = (
        apply_deterministic(chain, state)[0] for chain in ([one for one in effects if one.traits.absorbed], effects)
    )

    def posed(beyond_nT: Array) -> LinearProblem:
        problem = _about_iron(recording, state, iron_nT, policy, beyond_nT)
        problem = replace(problem, effects=effects, predicted_nT=predicted_nT, track=track)
        return replace(problem, turn=_turn(problem))

    problem = posed(beyond_iron_nT(smooth, state))
    for _ in range(STEPS if np.any(problem.beyond_nT) else 0):
        problem = posed(beyond_iron_nT(insert_effects(smooth, fitted_iron(problem)), state))
    return problem


def still_problem(recording: Recording, effects: tuple[Effect, ...], policy: Policy) -> LinearProblem:
    """The problem of three axes about a constant, see `LinearProblem`: iron and field are not separable at rest."""

    def posed(seen: Recording) -> LinearProblem:
        constant_nT = np.tile(np.median(seen.mag_nT, axis=0), (len(seen), 1))
        state = state_of(seen, constant_nT[0], constant_nT, field_rate_nT_s=np.zeros_like(constant_nT))
        problem = _about_iron(seen, state, None, policy)
        return replace(problem, inputs=problem.inputs - {"rate", "position"}, still=True)

    return pose_without_model_effects(posed, recording, effects)


def relative_problem(
    recording: Recording, reference_nT: Array, effects: tuple[Effect, ...], policy: Policy
) -> LinearProblem:
    """The problem of the three axes, see `LinearProblem`, with a reference magnetometer r (n, 3) as the field.

    ``y = A r + o + effects + noise``, A (3, 3) and o free: mounting, scale, and the iron of either sensor. Effects are
    in the axes of the first sensor; the model's iron is replaced by A and o. The residual has the noise of either
    sensor. Common disturbances, scaled by A, are not observable; disturbances of r alone have the opposite sign.
    Attitude and position are not used.
    """
    bare = replace(recording, att_q=None, pos_enu_m=None)
    own = {name: x for name, x in recording.channels.items() if name not in REFERENCE}
    seen = replace(bare, channels=own, gyro_rad_s=body_rate(recording))
    kept = tuple(effect for effect in without_iron(effects) if not IN_EARTH_FRAME & set(effect.needs))
    state = _reference_state(seen, reference_nT, policy)
    predicted_nT, _ = apply_deterministic(kept, state)
    problem = _about_iron(seen, state, predicted_nT, policy)
    return replace(problem, recording=bare, effects=kept, predicted_nT=predicted_nT, relative=True)


def _about_iron(
    recording: Recording, state: State, iron_nT: Array | None, policy: Policy, beyond_nT: Array | float = 0.0
) -> LinearProblem:
    """The problem of the axes about a robust fit of a free matrix on a field (n, 3), and an offset.

    At rest, without iron_nT, about the state's field. beyond_nT (n, 3): contributions that no iron changes.
    """
    base, clean, mag_nT = np.ones((len(recording), 1)), state.field_nT, recording.mag_nT - beyond_nT
    if iron_nT is not None:
        base = np.column_stack([iron_nT / np.linalg.norm(state.field_enu_nT), base])
        clean = base @ robust_fit(base, mag_nT, policy)
        fresh = ~held(recording.mag_nT, mag_nT - clean, policy)
        if not fresh.all():
            clean = base @ robust_fit(base[fresh], mag_nT[fresh], policy)
    residual = mag_nT - clean
    sigma = noise_of_neighbours(residual, recording.mag_nT, state.time_s, policy)
    return LinearProblem(
        recording=recording,
        state=state,
        effects=(),
        mode="vector",
        base=base,
        target=residual / sigma,
        sigma_nT=sigma,
        usable=np.ones(len(recording)),
        turn=np.eye(3),
        clean_nT=clean + beyond_nT,
        predicted_nT=state.field_nT,
        inputs=measured(recording),
        policy=policy,
        beyond_nT=beyond_nT,
    )


def _turn(problem: LinearProblem, least_rad: float = 0.0) -> Array:
    """Matrix (3, 3) from the undisturbed to the measured field, estimated with a field error c and a delay d.

    ``M (R^T (F + c) + d dT/dt) + b``, T the field in the body frame, is fitted in steps linear in M, b, c and d;
    without c and d the matrix would absorb them. Priors hold c and d at zero where the motion does not determine them:
    FIELD_ERROR of the field's strength and DELAY_S; `least_rad`: an attitude error that c must exceed.
    """
    state, sigma = problem.state, problem.sigma_nT
    clean = problem.clean_nT - problem.beyond_nT
    turn = fit_matrix(state.field_nT, clean)
    Q = np.linalg.qr(problem.base)[0]
    prior = np.diag(np.r_[np.full(3, FIELD_ERROR * np.linalg.norm(state.field_enu_nT)), DELAY_S] ** -2.0)
    prior[:3, :3] += np.eye(3) * len(state) * (least_rad**2 / sigma**2).sum()
    errors = np.concatenate([state.R_wb.transpose(0, 2, 1), state.field_rate_nT_s[:, :, None]], axis=2)
    for _ in range(STEPS):
        E = turn @ errors
        beyond_base = E - np.tensordot(Q, np.tensordot(Q, E, (0, 0)), 1)
        flat = (beyond_base / sigma[:, None]).reshape(-1, 4)
        c = np.linalg.lstsq(flat.T @ flat + prior, flat.T @ problem.target.ravel(), rcond=1e-12)[0]
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
    turn = _turn(problem, least_rad)
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


def _reference_state(seen: Recording, reference_nT: Array, policy: Policy) -> State:
    """State with a reference r (n, 3), in the axes and scale of the sensor m, as the field.

    ``A r`` with A (3, 3) near one by `matrix_prior`, which directions keep in which the motion shows only noise. The
    field's rate is ``-w x (A r - o)``, o by least squares: an offset does not turn with the field.
    """
    r, m = (values - values.mean(axis=0) for values in (reference_nT, seen.mag_nT))
    prior = np.eye(3) * float((sample_noise(m) ** 2).mean()) / policy.matrix_prior**2
    field_nT = reference_nT @ np.linalg.solve(r.T @ r + prior, r.T @ m + prior)
    rate, rate_nT_s = seen.gyro_rad_s, None
    if rate is not None:
        axes = [cross(rate, np.tile(axis, (len(rate), 1))) for axis in np.eye(3)]
        turned = smoothed_derivative(field_nT, seen.time_s) + cross(rate, field_nT)
        offset_nT = np.linalg.lstsq(np.stack(axes, axis=2).reshape(-1, 3), turned.ravel(), rcond=1e-6)[0]
        rate_nT_s = -cross(rate, field_nT - offset_nT)
    field_enu_nT = np.array([0.0, float(np.median(np.linalg.norm(field_nT, axis=1))), 0.0])
    return state_of(seen, field_enu_nT, field_nT, rate, rate_nT_s)

"""Problems of three axes: of a recording with attitude, of a sensor at rest, of a sensor beside a reference sensor."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from calib.numerics.rates import body_rate, smoothed_derivative
from diagnosis.policy import Policy
from diagnosis.problem.known import Known
from diagnosis.problem.linear import IN_EARTH_FRAME, LinearProblem, about_model_effects
from diagnosis.problem.motion import held, measured, motion_of, noise_of_neighbours, outliers, sample_noise, state_of
from recordings import Recording
from recordings.channels import REFERENCE
from scenarios.arrays import Array
from sim.chain import apply_deterministic
from sim.effects.chain_position import iron_matrix, without_iron
from sim.rotation import cross
from sim.state import State

FIELD_ERROR, DELAY_S = 0.02, 0.1
"""Standard deviations of a given field's relative error and of the delay against the attitude: priors where the
motion does not determine them.
"""
STEPS = 3
"""Steps to the matrix: each squares the error of the preceding step."""


def vector_problem(recording: Recording, field_enu_nT: Array, known: Known) -> LinearProblem:
    """The problem of the three axes, see `LinearProblem`, for a recording with attitude."""
    return _axes_problem(recording, motion_of(recording, field_enu_nT, known.policy, known.track), known)


def still_problem(recording: Recording, known: Known) -> LinearProblem:
    """The problem of three axes about a constant, see `LinearProblem`: iron and field are not separable at rest."""
    seen = replace(recording, gyro_rad_s=None, pos_enu_m=None)
    constant_nT = np.tile(np.median(recording.mag_nT, axis=0), (len(recording), 1))
    state = state_of(seen, constant_nT[0], constant_nT, field_rate_nT_s=np.zeros_like(constant_nT))
    fitted = replace(known, iron_known=False)
    problem = about_model_effects(partial(_about_base, seen, state, np.ones((len(seen), 1)), fitted))
    bare_nT = problem.clean_nT - problem.beyond_nT
    return replace(problem, recording=recording, clean_nT=bare_nT, beyond_nT=0.0, still=True)


def relative_problem(recording: Recording, reference_nT: Array, known: Known) -> LinearProblem:
    """The problem of the three axes, see `LinearProblem`, with a reference magnetometer r (n, 3) as the field.

    ``y = A r + o + effects + noise``, A (3, 3) and o free: mounting, scale, and the iron of either sensor. Effects are
    in the axes of the first sensor; the model's iron is replaced by A and o. The residual has the noise of either
    sensor. Common disturbances, scaled by A, are not observable; disturbances of r alone have the opposite sign.
    Attitude and position are not used.
    """
    bare = replace(recording, att_q=None, pos_enu_m=None)
    own = {name: x for name, x in recording.channels.items() if name not in REFERENCE}
    seen = replace(bare, channels=own, gyro_rad_s=body_rate(recording))
    effects = (effect for effect in without_iron(known.effects) if not IN_EARTH_FRAME & set(effect.needs))
    kept = replace(known, effects=tuple(effects), iron_known=False, attitude_std_rad=0.0)
    problem = _axes_problem(seen, _reference_state(seen, reference_nT, known.policy), kept)
    return replace(problem, recording=bare, relative=True)


def _axes_problem(recording: Recording, state: State, known: Known) -> LinearProblem:
    """The problem of the axes about a free matrix on the field behind the model's iron, and an offset."""
    # on the whole prediction a matrix would span a motor's field in the body frame, and take a wrong gain for iron
    iron = [effect for effect in known.effects if effect.traits.absorbed]
    iron_nT, predicted_nT = (apply_deterministic(chain, state)[0] for chain in (iron, known.effects))
    base = np.column_stack([iron_nT / np.linalg.norm(state.field_enu_nT), np.ones(len(recording))])
    problem = about_model_effects(partial(_about_base, recording, state, base, known))
    return replace(problem, predicted_nT=predicted_nT)


def _about_base(
    recording: Recording, state: State, base: Array, known: Known, beyond_nT: Array | float
) -> LinearProblem:
    """The problem of the axes about a robust fit of a base (n, p), less contributions (n, 3) beyond the iron."""
    mag_nT, policy = recording.mag_nT - beyond_nT, known.policy
    clean_nT = base @ robust_fit(base, mag_nT, policy)
    fresh = ~held(recording.mag_nT, mag_nT - clean_nT, policy)
    if not fresh.all():
        clean_nT = base @ robust_fit(base[fresh], mag_nT[fresh], policy)
    sigma = noise_of_neighbours(mag_nT - clean_nT, recording.mag_nT, state.time_s, policy)
    problem = LinearProblem(
        **vars(known),
        recording=recording,
        state=state,
        base=base,
        target=(mag_nT - clean_nT) / sigma,
        sigma_nT=sigma,
        usable=np.ones(len(recording)),
        turn=np.eye(3),
        clean_nT=clean_nT + beyond_nT,
        predicted_nT=clean_nT + beyond_nT,
        inputs=measured(recording),
        beyond_nT=beyond_nT,
    )
    return problem if recording.att_q is None else replace(problem, turn=_turn(problem))


def _turn(problem: LinearProblem) -> Array:
    """Matrix (3, 3) from the undisturbed to the measured field.

    A stated error of the attitude biases the matrix where the field varies little more: along such directions the
    model's matrix holds.
    """
    least_rad, state = problem.policy.tenfold * problem.attitude_std_rad * problem.turns, problem.state
    turn = _free_turn(problem, least_rad)
    if not least_rad:
        return turn
    values, directions = np.linalg.eigh(np.cov(state.field_nT.T))
    hidden = directions[:, values < (least_rad * np.linalg.norm(state.field_enu_nT)) ** 2]
    return np.asarray(turn + (iron_matrix(problem.effects, state) - turn) @ hidden @ hidden.T)


def _free_turn(problem: LinearProblem, least_rad: float) -> Array:
    """The matrix of `_turn` estimated with a field error c and a delay d.

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


def fit_matrix(field: Array, clean: Array) -> Array:
    """Matrix (3, 3) from the undisturbed field (n, 3) to the predicted measurement (n, 3): least squares."""
    design = np.column_stack([field, np.full(len(field), np.linalg.norm(field[0]))])
    return np.asarray(np.linalg.lstsq(design, clean, rcond=1e-6)[0][:3].T)


def robust_fit(base: Array, mag_nT: Array, policy: Policy) -> Array:
    """Least squares (p, q), repeated once without outliers, so that rare failures do not determine the base."""
    beta = np.linalg.lstsq(base, mag_nT, rcond=None)[0]
    far = outliers(mag_nT - base @ beta, policy)
    return np.asarray(np.linalg.lstsq(base[~far], mag_nT[~far], rcond=None)[0] if far.any() else beta)


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

"""Problem of one magnetometer against a reference magnetometer, whose rotated and scaled reading is the field."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from calib.numerics.rates import body_rate, smoothed_derivative
from diagnosis.policy import Policy
from diagnosis.problem.linear import LinearProblem, sample_noise
from diagnosis.problem.rates import course, measured
from diagnosis.problem.strength import measured_strength
from recordings import Recording
from recordings.channels import REFERENCE
from scenarios.arrays import Array
from scenarios.errors import InputError
from sim.chain import apply_deterministic
from sim.effects.base import Effect
from sim.effects.chain_position import without_iron
from sim.rotation import cross
from sim.scenario import Model
from sim.state import State

UNSEEN = frozenset({"attitude", "position"})
"""Inputs of effects not observable between two magnetometers: fields of the Earth's frame act on either."""


def recorded_reference(recording: Recording) -> Array | None:
    """Reading (n, 3) in nT of the reference magnetometer, None without a reference.

    Raises InputError for a missing axis, and for rows without a field.
    """
    there = [name for name in REFERENCE if name in recording.channels]
    if not there:
        return None
    missing = [name for name in REFERENCE if name not in there]
    if missing:
        what = f"there is no column {missing[0]} beside {there[0]}"
        raise InputError(what, where="recording", do="give all three axes of the reference")
    reference_nT = np.column_stack([recording.channels[name] for name in REFERENCE])
    if not np.isfinite(reference_nT).all() or not reference_nT.any(axis=1).all():
        what = f"{REFERENCE[0]} and its like have rows without a field"
        raise InputError(what, where="recording", do="give a field in nT in every row")
    return reference_nT


BY_MODEL = ", or a --model whose [field] has latitude_deg, longitude_deg and date"
"""Alternative to a stated field, for messages."""


def needs_field(recording: Recording, model: Model, *, stated: bool) -> bool:
    """Whether the Earth's field must be given; InputError for a field stated besides a reference magnetometer."""
    if recorded_reference(recording) is None:
        return stated or (model.field is None and measured_strength(recording) is None)
    if stated:
        what = "another magnetometer is the reference, and a field is stated too"
        raise InputError(what, where="reference", do="leave out one of the two")
    return False


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
    seen = replace(bare, channels={name: x for name, x in bare.channels.items() if name not in REFERENCE})
    kept = tuple(effect for effect in without_iron(effects) if not UNSEEN & set(effect.needs))
    state = _state(recording, seen, reference_nT @ _turn(reference_nT, recording.mag_nT, policy).T)
    predicted, _ = apply_deterministic(kept, state)
    base = np.column_stack([predicted / float(np.linalg.norm(reference_nT, axis=1).mean()), np.ones(len(recording))])
    clean = base @ np.linalg.lstsq(base, recording.mag_nT, rcond=None)[0]
    residual = recording.mag_nT - clean
    sigma = sample_noise(residual)
    return LinearProblem(
        recording=bare,
        state=state,
        effects=kept,
        mode="vector",
        base=base,
        target=residual / sigma,
        sigma_nT=sigma,
        usable=np.ones(len(recording)),
        turn=np.eye(3),
        clean_nT=clean,
        predicted_nT=predicted,
        inputs=measured(seen) | (measured(recording) & {"rate"}),
        policy=policy,
        relative=True,
    )


def _turn(reference_nT: Array, mag_nT: Array, policy: Policy) -> Array:
    """Matrix A (3, 3) from the reference's axes and scale to the sensor's, with a prior about one (`matrix_prior`).

    Directions in which the motion shows only noise keep the prior.
    """
    r, m = (values - values.mean(axis=0) for values in (reference_nT, mag_nT))
    prior = np.eye(3) * float((sample_noise(m) ** 2).mean()) / policy.matrix_prior**2
    return np.asarray(np.linalg.solve(r.T @ r + prior, r.T @ m + prior).T)


def _state(recording: Recording, seen: Recording, reference_nT: Array) -> State:
    n, rate = len(recording), body_rate(recording)
    derived = smoothed_derivative(reference_nT, recording.time_s)
    if rate is not None:
        derived = -cross(rate, reference_nT - _offset(rate, reference_nT, derived))
    return State(
        R_wb=np.tile(np.eye(3), (n, 1, 1)),
        rate_rad_s=np.zeros((n, 3)) if rate is None else rate,
        field_enu_nT=np.array([0.0, float(np.median(np.linalg.norm(reference_nT, axis=1))), 0.0]),
        field_nT=reference_nT,
        field_rate_nT_s=derived,
        **course(seen),
    )


def _offset(rate_rad_s: Array, reference_nT: Array, derived: Array) -> Array:
    """Offset o (3,) of the reference that does not turn with the field: ``dr/dt = -w x (r - o)``, least squares."""
    columns = np.stack([cross(rate_rad_s, np.tile(axis, (len(rate_rad_s), 1))) for axis in np.eye(3)], axis=2)
    target = derived + cross(rate_rad_s, reference_nT)
    return np.asarray(np.linalg.lstsq(columns.reshape(-1, 3), target.ravel(), rcond=1e-6)[0])

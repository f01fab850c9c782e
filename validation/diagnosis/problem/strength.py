"""The problem of a recording without attitude: only the field's strength is compared."""

from __future__ import annotations

import numpy as np

from calib import Calibration, Reference, get
from calib.numerics.rates import body_rate, smoothed_derivative
from scenarios.errors import InputError
from sim.dataset import Recording
from sim.effects.base import Effect
from sim.rotation import cross
from sim.state import SCALAR, Array, State
from validation.diagnosis.policy import Policy
from validation.diagnosis.problem.linear import LinearProblem, sample_noise
from validation.diagnosis.problem.motion import course, measured


def strength_problem(
    recording: Recording, strength_nT: float, effects: tuple[Effect, ...], policy: Policy
) -> LinearProblem:
    """The problem of the strength, see `LinearProblem`, about the ellipsoid that fits the recording.

    A scalar magnetometer beside it is the strength sample by sample, whatever was given: it must be compensated.
    Raises InputError where the motion does not determine an ellipsoid.
    """
    measured_nT = measured_strength(recording)
    F = np.full((1, 1), strength_nT) if measured_nT is None else measured_nT
    fit = _ellipsoid(recording, float(np.median(F)))
    h = (recording.mag_nT - fit.offset_nT) @ fit.matrix.T
    size = np.linalg.norm(h, axis=1, keepdims=True)
    direction = h / size
    residual = size - F
    sigma = sample_noise(residual)
    turn: Array = np.asarray(np.linalg.inv(fit.matrix), dtype=np.float64)
    state = _state(recording, direction * F, float(np.median(F)))
    clean = state.field_nT @ turn.T + fit.offset_nT
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
        has=measured(recording),
        policy=policy,
    )


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


def strength_columns(direction: Array) -> Array:
    """Changes (n, 9) of the strength with a symmetric matrix and an offset, along unit directions (n, 3)."""
    pairs = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)]
    return np.column_stack([*(direction[:, i] * direction[:, j] for i, j in pairs), direction])


def _ellipsoid(recording: Recording, strength_nT: float) -> Calibration:
    fit = get("ellipsoid").fit(recording, Reference(strength_nT, None), np.random.default_rng(0))
    if not np.isfinite(fit.matrix).all() or fit.status.kind == "not_applicable":
        do = "give a recording with attitude, or one that turns the sensor in all directions"
        raise InputError(f"no attitude, and no ellipsoid fits: {fit.status.reason}", where="recording", do=do)
    return fit


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

"""Problem of a recording at rest: every axis is compared with a constant."""

from __future__ import annotations

import numpy as np

from diagnosis.policy import Policy
from diagnosis.problem.iron_fit import fit_iron
from diagnosis.problem.linear import LinearProblem
from diagnosis.problem.model_effects import pose_without_model_effects
from diagnosis.problem.rates import course, measured
from diagnosis.problem.repeated_rows import noise_of_neighbours
from recordings import Recording
from scenarios.arrays import Array
from sim.effects.base import Effect
from sim.state import State
from validation.signals.amplitude import rms


def at_rest(recording: Recording, strength_nT: float, policy: Policy) -> bool:
    """Whether a recording without attitude comes from a sensor that does not turn, in a field of a given strength.

    Either the field stays within a small angle, or its changes follow the recorded channels and not a motion: a turning
    sensor may follow its own pitch and roll, but keeps the strength of the field. Coils that are switched give few
    values, and iron of constant strength fits any few values: the channels must then leave hardly more than the iron.
    """
    if recording.att_q is not None or _turning(recording, policy):
        return False
    m = recording.mag_nT
    if np.linalg.norm(m.std(axis=0)) < policy.still_spread * np.linalg.norm(m.mean(axis=0)):
        return True
    return _moved_by_channels(recording, strength_nT, policy)


def _moved_by_channels(recording: Recording, strength_nT: float, policy: Policy) -> bool:
    m, left_nT = recording.mag_nT, _left_by_channels_nT(recording)
    if 1 - (left_nT**2).sum() / ((m - m.mean(axis=0)) ** 2).sum() < policy.half:
        return False
    first, second, _ = np.linalg.svd(m - m.mean(axis=0), compute_uv=False)
    if second < policy.little * first:
        return True
    corrected_nT = _corrected_nT(recording, strength_nT, policy)
    off_nT = float(np.linalg.norm(corrected_nT, axis=1).std())
    keeps_strength = off_nT < policy.trace * float(np.linalg.norm(corrected_nT.std(axis=0)))
    return not keeps_strength or rms(left_nT) < policy.much_larger * off_nT


def still_problem(recording: Recording, effects: tuple[Effect, ...], policy: Policy) -> LinearProblem:
    """The problem of three axes about a constant, see `LinearProblem`: iron and field are not separable at rest."""
    return pose_without_model_effects(lambda seen: _about_a_constant(seen, policy), recording, effects)


def _about_a_constant(recording: Recording, policy: Policy) -> LinearProblem:
    n = len(recording)
    constant = np.tile(np.median(recording.mag_nT, axis=0), (n, 1))
    residual = recording.mag_nT - constant
    sigma = noise_of_neighbours(residual, recording.mag_nT, recording.time_s, policy)
    zero = np.zeros((n, 3))
    state = State(
        R_wb=np.tile(np.eye(3), (n, 1, 1)),
        rate_rad_s=zero,
        field_enu_nT=constant[0],
        field_nT=constant,
        field_rate_nT_s=zero,
        **course(recording),
    )
    return LinearProblem(
        recording=recording,
        state=state,
        effects=(),
        mode="vector",
        base=np.ones((n, 1)),
        target=residual / sigma,
        sigma_nT=sigma,
        usable=np.ones(n),
        turn=np.eye(3),
        clean_nT=constant,
        predicted_nT=constant,
        inputs=measured(recording) - {"rate", "position"},
        policy=policy,
        still=True,
    )


def _turning(recording: Recording, policy: Policy) -> bool:
    gyro = recording.gyro_rad_s
    return gyro is not None and bool(np.abs(gyro - np.median(gyro, axis=0)).max(axis=1).mean() > policy.still_rate)


def _corrected_nT(recording: Recording, strength_nT: float, policy: Policy) -> Array:
    """Field (n, 3) corrected by the iron that best reproduces the given strength."""
    m = recording.mag_nT
    block = max(1, round(policy.block_s / float(np.median(np.diff(recording.time_s)))))
    return np.asarray(fit_iron(m, np.full(len(m), strength_nT), block, policy).field_nT(m))


def _left_by_channels_nT(recording: Recording) -> Array:
    """Residual (n, 3) of the field about its mean after linear regression on currents and channels."""
    columns: list[Array] = list(recording.channels.values())
    if recording.current_A is not None:
        columns += list(recording.current_A.T)
    moving = [column - column.mean() for column in columns if np.isfinite(column).all() and np.ptp(column) > 0]
    m: Array = recording.mag_nT - recording.mag_nT.mean(axis=0)
    if not moving:
        return m
    X = np.stack([column / column.std() for column in moving], axis=1)
    return np.asarray(m - X @ np.linalg.lstsq(X, m, rcond=1e-9)[0])

"""The problem of a recording at rest: every axis is compared with a constant."""

from __future__ import annotations

import numpy as np

from sim.dataset import Recording
from sim.effects.base import Effect
from sim.state import Array, State
from validation.diagnosis.policy import Policy
from validation.diagnosis.problem.held import noise_of_neighbours
from validation.diagnosis.problem.iron_by_strength import fitted_iron
from validation.diagnosis.problem.linear import LinearProblem
from validation.diagnosis.problem.motion import course, measured


def at_rest(recording: Recording, strength_nT: float, policy: Policy) -> bool:
    """Whether a recording without attitude is one of a sensor that does not turn, in a field of some strength.

    Its field stays within a small angle, or what moves it goes with the recorded channels and not with a motion: a
    sensor that turns goes with its own pitch and roll, but keeps the field's strength.
    """
    if recording.att_q is not None or _turning(recording, policy):
        return False
    m = recording.mag_nT
    if np.linalg.norm(m.std(axis=0)) < policy.still_spread * np.linalg.norm(m.mean(axis=0)):
        return True
    return _share_of_channels(recording) > policy.still_share and not _keeps_strength(recording, strength_nT, policy)


def still_problem(recording: Recording, effects: tuple[Effect, ...], policy: Policy) -> LinearProblem:
    """The problem of three axes about a constant, see `LinearProblem`: iron and field are one there."""
    n = len(recording)
    constant = np.tile(np.median(recording.mag_nT, axis=0), (n, 1))
    left = recording.mag_nT - constant
    sigma = noise_of_neighbours(left, recording.mag_nT, recording.time_s, policy)
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
        effects=effects,
        mode="vector",
        base=np.ones((n, 1)),
        target=left / sigma,
        sigma_nT=sigma,
        usable=np.ones(n),
        turn=np.eye(3),
        clean_nT=constant,
        predicted_nT=constant,
        has=measured(recording) - {"rate", "position"},
        policy=policy,
        still=True,
    )


def _turning(recording: Recording, policy: Policy) -> bool:
    gyro = recording.gyro_rad_s
    return gyro is not None and bool(np.abs(gyro - np.median(gyro, axis=0)).max(axis=1).mean() > policy.still_rate)


def _keeps_strength(recording: Recording, strength_nT: float, policy: Policy) -> bool:
    """Whether iron fitted to the strength takes up nearly all of what moves the field, and that is no line."""
    m = recording.mag_nT
    first, second, _ = np.linalg.svd(m - m.mean(axis=0), compute_uv=False)
    if second < policy.still_line * first:
        return False
    block = max(1, round(policy.block_s / float(np.median(np.diff(recording.time_s)))))
    corrected_nT = fitted_iron(m, np.full(len(m), strength_nT), block, policy).field_nT(m)
    unit = float(np.linalg.norm(corrected_nT.std(axis=0)))
    return float(np.linalg.norm(corrected_nT, axis=1).std()) < policy.still_strength * unit


def _share_of_channels(recording: Recording) -> float:
    """Share of the field's variance that a straight line in every current and channel explains."""
    columns: list[Array] = list(recording.channels.values())
    if recording.current_A is not None:
        columns += list(recording.current_A.T)
    moving = [one - one.mean() for one in columns if np.isfinite(one).all() and np.ptp(one) > 0]
    if not moving:
        return 0.0
    m = recording.mag_nT - recording.mag_nT.mean(axis=0)
    X = np.stack([one / one.std() for one in moving], axis=1)
    left = m - X @ np.linalg.lstsq(X, m, rcond=1e-9)[0]
    return 1 - float((left**2).sum() / max((m**2).sum(), 1e-300))

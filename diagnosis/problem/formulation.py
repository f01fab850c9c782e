"""Formulation of the problem from a recording and a model."""

from __future__ import annotations

import itertools
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.fft import dct, idct

from calib.numerics.noise import white_noise_std
from diagnosis.policy import STANDARD, Policy
from diagnosis.problem.known import FieldTrack, Known, ReferenceCorrection
from diagnosis.problem.linear import LinearProblem
from diagnosis.problem.motion import attitude_at_its_time, motion_of
from diagnosis.problem.sensors import recorded_reference
from diagnosis.problem.strength import fit_iron, strength_problem
from diagnosis.problem.vector import relative_problem, still_problem, vector_problem
from recordings import Recording
from recordings.channels import SCALAR
from scenarios.arrays import Array
from scenarios.errors import InputError
from scenarios.spec import FieldSpec
from sim.chain import apply_deterministic
from sim.effects import EFFECTS
from sim.effects.chain_position import without_iron
from sim.field import earth_field_enu_nT
from sim.scenario import Model
from validation.signals.amplitude import rms
from validation.text import duration

NOMINAL_NT = 5e4
"""Strength in place of an unstated field: scales a fit without attitude, without effect on decisions."""
LONGEST_S = min(p.high for effect in EFFECTS for p in effect.parameters() if p.role == "moment")
"""Upper bound of the step-time parameters of all effects."""


def pose(recording: Recording, known: Known) -> LinearProblem:
    """The problem of a recording: in vector mode with attitude and field vector, in strength mode otherwise.

    With a level in place of attitude the dip is compared as well. A recorded reference magnetometer replaces the field.
    At rest without attitude every axis is compared with a constant. With a track, field and strength hold at its middle
    place and vary along the track.

    Raises InputError for a recording too short for held-out segments or longer than `LONGEST_S`, and in strength mode
    for a motion that does not determine an ellipsoid.
    """
    if len(recording) < known.policy.least_samples:
        what = f"{len(recording)} samples, at least {known.policy.least_samples} are needed"
        do = "give a longer recording; magbench calibrate needs ten samples only"
        raise InputError(what, where="recording", do=do)
    if (length_s := float(np.ptp(recording.time_s))) > LONGEST_S:
        what = f"lasts {duration(length_s)}, and at most {duration(LONGEST_S)} are diagnosed"
        do = "give a part of it; or if its time stamps are no seconds, say so by --map time_s=COLUMN,unit=us"
        raise InputError(what, where="recording", do=do)
    if (reference_nT := recorded_reference(recording)) is not None:
        return relative_problem(recording, reference_nT, known)
    if recording.att_q is not None and known.given_enu_nT is not None:
        problem = vector_problem(recording, known.given_enu_nT, known)
    elif known.level is None and at_rest(recording, known.strength_nT, known.policy):
        problem = still_problem(recording, known)
    else:
        problem = strength_problem(recording, known)
    return without_their_noise(problem)


def pose_model(
    recording: Recording,
    model: Model,
    field_enu_nT: Array | None,
    strength_nT: float | None,
    *,
    iron_known: bool = True,
    policy: Policy = STANDARD,
) -> LinearProblem:
    """The problem of a recording and a model, with the model's field unless a field is given.

    With `iron_known` false the model's iron is replaced by a fit.

    Raises InputError as `pose` does, and for an invalid effect table of the model.
    """
    track, navigation = FieldTrack.of(recording, model.field), model.navigation
    if field_enu_nT is None and model.field is not None:
        field_enu_nT = _field_enu_nT(model.field, track)
    known = Known(
        field_enu_nT,
        strength_nT or NOMINAL_NT if field_enu_nT is None else float(np.linalg.norm(field_enu_nT)),
        model.chain() if iron_known else without_iron(model.chain()),
        policy,
        track,
        iron_known=iron_known,
        attitude_std_rad=float(np.radians(navigation.attitude_noise_std_deg)),
        attitude_delay_s=navigation.attitude_delay_s,
    )
    in_time, share, unknown = attitude_at_its_time(recording, navigation.attitude_delay_s, policy)
    problem = pose(in_time, known)
    if not problem.turns:
        return problem
    words = f"The attitude is repeated in {100 * share:.0f} % of the rows, and was taken between its own values."
    figures = "Log the attitude with its own times, or leave the cells empty in which it is not new."
    told = (ReferenceCorrection(words, figures),) if share else ()
    return replace(problem, corrections=told).without(unknown)


def simulated_nT(recording: Recording, model: Model, policy: Policy = STANDARD) -> Array:
    """The field (n, 3) that a model with a field gives along the recorded attitude, without any fit."""
    assert model.field is not None
    track = FieldTrack.of(recording, model.field)
    in_time, _, _ = attitude_at_its_time(recording, model.navigation.attitude_delay_s, policy)
    return apply_deterministic(model.chain(), motion_of(in_time, _field_enu_nT(model.field, track), policy, track))[0]


def _field_enu_nT(given: FieldSpec, track: FieldTrack | None) -> Array:
    """Field (3,) of the model; for a model by date, at the middle of the track if there is a track."""
    return earth_field_enu_nT(given) if track is None or given.enu_nT is not None else track.field_enu_nT


def pose_again(problem: LinearProblem, recording: Recording | None = None, **changes: Any) -> LinearProblem:
    """The problem with changes of what is known, and of another recording if given; all else as before.

    Raises InputError as `pose` does.
    """
    known = replace(problem.known, **changes)
    return pose(problem.recording if recording is None else recording, known).without(problem.usable == 0)


def refit_iron(problem: LinearProblem, disturbance_nT: Array) -> LinearProblem:
    """A strength problem with iron fitted after a disturbance (n, 3) of the measurement is subtracted."""
    anew = strength_problem(problem.recording, problem.known, disturbance_nT)
    return replace(anew, state=replace(anew.state, channels=problem.state.channels)).without(problem.usable == 0)


def at_rest(recording: Recording, strength_nT: float, policy: Policy) -> bool:
    """Whether a recording without attitude comes from a sensor that does not turn, in a field of a given strength.

    Either the field stays within a small angle, or its changes follow the recorded channels and not a motion: a turning
    sensor may follow its own pitch and roll, but keeps the strength of the field. Coils that are switched give few
    values, and iron of constant strength fits any few values: the channels must then leave hardly more than the iron.
    """
    m, gyro = recording.mag_nT, recording.gyro_rad_s
    if recording.att_q is not None:
        return False
    if gyro is not None and np.abs(gyro - np.median(gyro, axis=0)).max(axis=1).mean() > policy.still_rate:
        return False
    if np.linalg.norm(m.std(axis=0)) < policy.still_spread * np.linalg.norm(m.mean(axis=0)):
        return True
    changes, left_nT = m - m.mean(axis=0), _left_by_channels_nT(recording)
    if 1 - (left_nT**2).sum() / (changes**2).sum() < policy.half:
        return False
    first, second, _ = np.linalg.svd(changes, compute_uv=False)
    if second < policy.little * first:
        return True
    corrected_nT = fit_iron(m, np.full(len(m), strength_nT), recording.time_s, policy).field_nT(m)
    off_nT = float(np.linalg.norm(corrected_nT, axis=1).std())
    keeps_strength = off_nT < policy.trace * float(np.linalg.norm(corrected_nT.std(axis=0)))
    return not keeps_strength or rms(left_nT) < policy.much_larger * off_nT


def _left_by_channels_nT(recording: Recording) -> Array:
    """Residual (n, 3) of the field about its mean after linear regression on currents and channels."""
    columns = [*recording.channels.values(), *(() if recording.current_A is None else recording.current_A.T)]
    moving = [column - column.mean() for column in columns if np.isfinite(column).all() and np.ptp(column) > 0]
    m: Array = recording.mag_nT - recording.mag_nT.mean(axis=0)
    if not moving:
        return m
    X = np.stack(moving, axis=1) / np.std(moving, axis=1)
    return np.asarray(m - X @ np.linalg.lstsq(X, m, rcond=1e-9)[0])


def without_their_noise(problem: LinearProblem) -> LinearProblem:
    """The problem with smoothed channels, except channels whose noise is signal in the magnetometer.

    An effect driven by a noisy channel is estimated too small, and its lag too long.
    """
    channels = dict(problem.state.channels)
    for name, x in channels.items():
        if name != SCALAR and np.isfinite(x).all():
            smooth = smoothed(x, problem.policy.bands)
            columns = problem.sensor_axes(x - smooth)
            squares = np.maximum((columns**2).sum(axis=(0, 1)), 1e-300)
            nats = (np.einsum("nqk,nq->k", columns, problem.target) ** 2 / squares).sum() / 2
            channels[name] = x if nats > problem.policy.apart else smooth
    return replace(problem, state=replace(problem.state, channels=channels))


def smoothed(x: Array, bands: int) -> Array:
    """A series (n,) without white noise: Wiener filter ``max(0, 1 - s^2 / P)`` of the mirrored series.

    P : power in bands evenly spaced in log frequency; s : white noise from differences of neighbours.
    """
    std = float(white_noise_std(x[:, None])[0])
    spectrum = dct(x, norm="ortho")
    edges = np.unique(np.geomspace(1, len(x), bands).astype(int))
    for a, b in itertools.pairwise(edges):
        spectrum[a:b] *= max(0.0, 1.0 - std**2 / max(float((spectrum[a:b] ** 2).mean()), 1e-300))
    return np.asarray(idct(spectrum, norm="ortho"))

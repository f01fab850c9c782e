"""Formulation of the problem from a recording and a model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from diagnosis.policy import STANDARD, Policy
from diagnosis.problem.at_rest import at_rest, still_problem
from diagnosis.problem.channels import without_their_noise
from diagnosis.problem.level import Level
from diagnosis.problem.linear import LinearProblem, ReferenceCorrection
from diagnosis.problem.rates import moved_attitude
from diagnosis.problem.relative import recorded_reference, relative_problem
from diagnosis.problem.repeated_attitude import ContinuousAttitude, interpolate_attitude
from diagnosis.problem.strength import strength_problem
from diagnosis.problem.track import FieldTrack
from diagnosis.problem.vector import motion_of, vector_problem, with_attitude_std
from recordings import Recording
from scenarios.arrays import Array
from scenarios.errors import InputError
from scenarios.spec import FieldSpec
from sim.chain import apply_deterministic
from sim.effects import EFFECTS
from sim.effects.base import Effect
from sim.effects.chain_position import without_iron
from sim.field import earth_field_enu_nT
from sim.scenario import Model
from validation.text import duration

NOMINAL_NT = 5e4
"""Strength in place of an unstated field: scales a fit without attitude, without effect on decisions."""

LONGEST_S = min(p.high for effect in EFFECTS for p in effect.parameters() if p.role == "moment")
"""Upper bound of the step-time parameters of all effects."""


def pose(
    recording: Recording,
    field_enu_nT: Array | None,
    strength_nT: float,
    effects: tuple[Effect, ...],
    policy: Policy = STANDARD,
    track: FieldTrack | None = None,
    level: Level | None = None,
) -> LinearProblem:
    """The problem of a recording: in vector mode with attitude and field vector, in strength mode otherwise.

    With a level in place of attitude the dip is compared as well. A recorded reference magnetometer replaces the field.
    At rest without attitude every axis is compared with a constant. With a track, field and strength hold at its middle
    place and vary along the track.

    Raises InputError for a recording too short for held-out segments or longer than `LONGEST_S`, and in strength mode
    for a motion that does not determine an ellipsoid.
    """
    _check_length(recording, policy)
    if (reference_nT := recorded_reference(recording)) is not None:
        return relative_problem(recording, reference_nT, effects, policy)
    if recording.att_q is not None and field_enu_nT is not None:
        problem = vector_problem(recording, field_enu_nT, effects, policy, track)
    elif level is None and at_rest(recording, strength_nT, policy):
        problem = still_problem(recording, effects, policy)
    else:
        problem = strength_problem(recording, strength_nT, effects, policy, None, track, level, field_enu_nT)
    return without_their_noise(problem)


def _check_length(recording: Recording, policy: Policy) -> None:
    if len(recording) < policy.least_samples:
        what = f"{len(recording)} samples, at least {policy.least_samples} are needed"
        do = "give a longer recording; magbench calibrate needs ten samples only"
        raise InputError(what, where="recording", do=do)
    if (length_s := float(np.ptp(recording.time_s))) > LONGEST_S:
        what = f"lasts {duration(length_s)}, and at most {duration(LONGEST_S)} are diagnosed"
        do = "give a part of it; or if its time stamps are no seconds, say so by --map time_s=COLUMN,unit=us"
        raise InputError(what, where="recording", do=do)


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
    effects = model.chain() if iron_known else without_iron(model.chain())
    track = FieldTrack.of(recording, model.field)
    if field_enu_nT is None and model.field is not None:
        field_enu_nT = _field_enu_nT(model.field, track)
    strength = strength_nT or NOMINAL_NT if field_enu_nT is None else float(np.linalg.norm(field_enu_nT))
    steady, navigation = interpolate_attitude(recording, policy), model.navigation
    in_time, unknown = moved_attitude(steady.recording, navigation.attitude_delay_s)
    problem = _with_correction(steady, pose(in_time, field_enu_nT, strength, effects, policy, track)).without(unknown)
    stated_deg = 0.0 if problem.relative else navigation.attitude_noise_std_deg
    known = iron_known and not (problem.still or problem.relative)
    stated = replace(problem, iron_known=known, attitude_delay_s=navigation.attitude_delay_s)
    return with_attitude_std(stated, float(np.radians(stated_deg)))


def simulated_nT(recording: Recording, model: Model, policy: Policy = STANDARD) -> Array:
    """The field (n, 3) that a model with a field gives along the recorded attitude, without any fit."""
    assert model.field is not None
    track, steady = FieldTrack.of(recording, model.field), interpolate_attitude(recording, policy).recording
    in_time, _ = moved_attitude(steady, model.navigation.attitude_delay_s)
    state = motion_of(in_time, _field_enu_nT(model.field, track), policy, track)
    return apply_deterministic(model.chain(), state)[0]


def pose_again(
    problem: LinearProblem,
    recording: Recording,
    field_enu_nT: Array | None,
    done: ReferenceCorrection,
    level: Level | None = None,
) -> LinearProblem:
    """The problem of a corrected recording and field, None for strength (and dip) alone; all else unchanged.

    done : the correction, with the field (3,) that now holds if it changed. Raises InputError as `pose` does.
    """
    holds_enu_nT = field_enu_nT if done.field_enu_nT is None else done.field_enu_nT
    strength_nT = float(np.linalg.norm(problem.state.field_enu_nT if holds_enu_nT is None else holds_enu_nT))
    anew = pose(recording, field_enu_nT, strength_nT, problem.effects, problem.policy, problem.track, level)
    kept = replace(anew, corrections=(*problem.corrections, done), **problem.findings)
    return with_attitude_std(kept, problem.attitude_std_rad).without(problem.usable == 0)


def _with_correction(steady: ContinuousAttitude, problem: LinearProblem) -> LinearProblem:
    """The problem with a note on an interpolated attitude, and without the rows after the attitude's last value."""
    if not (steady.repeated and problem.turns):
        return problem
    share = f"{100 * steady.repeated:.0f} %"
    words = f"The attitude is repeated in {share} of the rows, and was taken between its own values."
    figures = "Log the attitude with its own times, or leave the cells empty in which it is not new."
    told = ReferenceCorrection(words, figures)
    return replace(problem, corrections=(told,)).without(steady.unknown)


def _field_enu_nT(given: FieldSpec, track: FieldTrack | None) -> Array:
    """Field (3,) of the model; for a model by date, at the middle of the track if there is a track."""
    return earth_field_enu_nT(given) if track is None or given.enu_nT is not None else track.field_enu_nT(given)

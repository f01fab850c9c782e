"""An attitude logged late: the field leads it, which free coefficients on the field's rate imitate."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar

from diagnosis.decision.joint_iron import select_jointly
from diagnosis.decision.selection import Progress, Selection
from diagnosis.decision.white_choice import AcceptedEffect
from diagnosis.evidence.baseline import Baseline
from diagnosis.problem.blocks import fit
from diagnosis.problem.formulation import pose_again
from diagnosis.problem.linear import LinearProblem, ReferenceCorrection
from diagnosis.problem.rates import attitude_at, attitude_course
from sim.effects.traits import LATE
from sim.rotation import matrix_from_q, to_body
from validation.signals.amplitude import rms
from validation.signals.quaternion_conventions import match_rates
from validation.text import figure

FARTHEST, SETTLED_S = 3.0, 1e-6
"""Largest lead tried, over the first guess, and the accuracy of the search."""


def correct_late_attitude(selection: Selection, say: Progress = lambda what: None) -> Selection:
    """Select again with the attitude moved in time, where a common lead explains as much as a late-field effect.

    A late measurement is one of the effects; a measurement ahead of the attitude is none, but the effects with free
    coefficients on the field's rate fit it. Where one lead for all axes explains nearly as much, and the effect is not
    accepted next to the lead, the attitude is late. A varying delay leaves too much for any effect to be accepted: the
    lead must then lower the gap as another reading of the reference would, or agree with the gyro, which is independent
    of the field.
    """
    if not selection.start.problem.turns:
        return selection
    named = _late_effect(selection)
    corrected = _problem_with_lead(selection, named)
    if corrected is None:
        return selection
    again = select_jointly(corrected, selection.without, say)
    return selection if named is not None and _remains(named, selection, again) else again


def _remains(named: AcceptedEffect, selection: Selection, again: Selection) -> bool:
    """Whether an effect is accepted next to the lead too; in a coloured residual, larger than its form error."""
    share = 0.0 if selection.after.clean else selection.start.problem.policy.same_form_share
    least_nT = share * _size_nT(named, selection)
    look_alikes = (effect for effect in again.accepted if named.name in (effect.name, *effect.alternatives))
    return any(_size_nT(effect, again) > least_nT for effect in look_alikes)


def _size_nT(effect: AcceptedEffect, selection: Selection) -> float:
    return effect.evidence.strength * rms(selection.start.problem.sigma_nT)


def _late_effect(selection: Selection) -> AcceptedEffect | None:
    """The accepted effect of a late field whose coefficients may have either sign."""
    late = [effect for effect in selection.accepted if effect.evidence.candidate.effect.traits.family == LATE]
    return next(
        (
            effect
            for effect in late
            if effect.evidence.candidate.effect.linear and not effect.evidence.candidate.one_run
        ),
        None,
    )


def _problem_with_lead(selection: Selection, named: AcceptedEffect | None) -> LinearProblem | None:
    """The problem with the attitude moved, if a lead explains nearly as much as the effect, or nearly all by itself."""
    start, policy = selection.start, selection.start.problem.policy
    first_s = _first_lead_s(start)
    if first_s <= policy.fair_share * start.problem.state.interval_s:
        return None
    q_at = _attitude_spline(start.problem)
    lead_s = _best_lead_s(start.problem, q_at, first_s)
    if named is None:
        before_nT, after_nT = (_gap_nT(start.problem, q_at, one_s) for one_s in (0.0, lead_s))
        shown = after_nT * policy.far_larger < before_nT or (
            after_nT < before_nT and _gyro_agrees(start.problem, lead_s)
        )
        return _with_lead(start.problem, q_at, lead_s) if shown else None
    moved = _with_lead(start.problem, q_at, lead_s)
    baselines = (start, start.with_columns(named.columns(start.problem)), Baseline.of(moved))
    before, by_name, by_lead = map(_power_nT2, baselines)
    by_form = policy.same_family if selection.after.clean else policy.same_coloured
    return moved if before - by_lead > (1 - by_form) * (before - by_name) else None


def _gyro_agrees(problem: LinearProblem, lead_s: float) -> bool:
    """Whether the gyro's rate leads the attitude by about as much as the field does."""
    recording = problem.recording
    if recording.gyro_rad_s is None:
        return False
    match = match_rates(recording.time_s, np.asarray(recording.att_q), recording.gyro_rad_s)
    return match is not None and abs(match.lag_s - lead_s) < problem.policy.half * lead_s


def _first_lead_s(start: Baseline) -> float:
    """Coefficient of the field's rate, common to all axes: the lead itself, if small."""
    rate = start.problem.field_columns(start.problem.state.field_rate_nT_s[:, :, None])
    return float(fit(start.sums_with(rate), start.all_folds).c[-1])


def _attitude_spline(problem: LinearProblem) -> CubicSpline:
    """Spline of the logged attitude."""
    return attitude_course(problem.recording.time_s, np.asarray(problem.recording.att_q))


def _best_lead_s(problem: LinearProblem, q_at: CubicSpline, first_s: float) -> float:
    """The lead (s) for which a free matrix and offset leave the smallest gap."""
    found = minimize_scalar(
        lambda lead_s: _gap_nT(problem, q_at, lead_s),
        bounds=(0.0, FARTHEST * first_s),
        method="bounded",
        options={"xatol": SETTLED_S},
    )
    return float(found.x)


def _gap_nT(problem: LinearProblem, q_at: CubicSpline, lead_s: float) -> float:
    """Rms (nT) of the measured field after a free matrix and offset, along the moved attitude."""
    used = (problem.usable > 0) & _known_attitude(problem, lead_s)
    change_enu_nT = np.zeros((1, 3)) if problem.track is None else problem.track.change_enu_nT
    turns = matrix_from_q(attitude_at(q_at, problem.recording.time_s + lead_s))
    field_nT = to_body(turns, problem.state.field_enu_nT + change_enu_nT)
    base = np.column_stack([field_nT / 1e4, np.ones(len(field_nT))])[used]
    mag_nT = problem.recording.mag_nT[used]
    return rms(mag_nT - base @ np.linalg.lstsq(base.T @ base, base.T @ mag_nT, rcond=1e-13)[0])


def _known_attitude(problem: LinearProblem, lead_s: float) -> NDArray[np.bool_]:
    """Samples (n,) whose attitude was logged before the end of the known part."""
    time_s = problem.recording.time_s
    return np.asarray(time_s + lead_s <= time_s[problem.usable > 0][-1])


def _with_lead(problem: LinearProblem, q_at: CubicSpline, lead_s: float) -> LinearProblem:
    """The problem posed again with the attitude moved, all else unchanged."""
    recording = replace(problem.recording, att_q=attitude_at(q_at, problem.recording.time_s + lead_s))
    done = _correction(lead_s, _gap_nT(problem, q_at, 0.0), _gap_nT(problem, q_at, lead_s))
    moved = pose_again(problem, recording, problem.state.field_enu_nT, done)
    in_all = replace(moved, attitude_delay_s=problem.attitude_delay_s + lead_s)
    return in_all.without(~_known_attitude(problem, lead_s))


def _correction(lead_s: float, before_nT: float, after_nT: float) -> ReferenceCorrection:
    late = f"{figure(1e3 * lead_s)} ms"
    figures = (
        f"Correct the time stamps: with the attitude {late} earlier the gap falls from {figure(before_nT)} to "
        f"{figure(after_nT)} nT, and the rest was found so; the new model "
        f"states it as navigation.attitude_delay_s. An eddy_current of {figure(lead_s)} s alike on "
        "all axes, which is "
        "ahead of the field and not behind it, would look the same."
    )
    return ReferenceCorrection(f"The attitude comes {late} later than the field, and was moved to its time.", figures)


def _power_nT2(baseline: Baseline) -> float:
    """Mean square (nT^2) of the residual of a baseline."""
    return rms(baseline.residual() * baseline.problem.sigma_nT) ** 2

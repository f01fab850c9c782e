"""An attitude logged late: the field leads it, which free coefficients on the field's rate imitate."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar

from diagnosis.decision.choice import AcceptedEffect
from diagnosis.decision.selection import Selection
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.reference_checks import gap_beside_iron_nT
from diagnosis.problem.blocks import fit
from diagnosis.problem.formulation import pose_again
from diagnosis.problem.linear import LinearProblem, ReferenceCorrection
from diagnosis.problem.motion import attitude_at, attitude_course
from sim.effects.traits import LATE
from sim.rotation import matrix_from_q, to_body
from validation.signals.amplitude import rms
from validation.signals.quaternion_conventions import match_rates
from validation.text import figure

FARTHEST, SETTLED_S = 3.0, 1e-6
"""Largest lead tried, over the first guess, and the accuracy of the search."""


def attitude_in_time(selection: Selection) -> Iterator[tuple[str, LinearProblem]]:
    """The attitude moved in time, where a common lead explains as much as a late-field effect, or nearly all by itself.

    A late measurement is one of the effects; a measurement ahead of the attitude is none, but the effects with free
    coefficients on the field's rate fit it. A varying delay leaves too much for any effect to be accepted: the lead
    must then lower the gap as another reading of the reference would, or agree with the gyro, which is independent of
    the field.
    """
    start, problem = selection.start, selection.start.problem
    policy = problem.policy
    if not problem.turns:
        return
    rate = problem.whitened(problem.state.field_rate_nT_s[:, :, None])
    first_s = float(fit(start.sums_with(rate), start.all_folds).c[-1])  # common to all axes: the lead, if small
    if first_s <= policy.fair_share * problem.state.interval_s:
        return
    q_at = attitude_course(problem.recording.time_s, np.asarray(problem.recording.att_q))
    lead_s = best_lead_s(problem, q_at, first_s)
    before_nT, after_nT = lead_gap_nT(problem, q_at, 0.0), lead_gap_nT(problem, q_at, lead_s)
    moved = _moved(problem, q_at, lead_s, before_nT, after_nT)
    if (named := _late_effect(selection)) is None:
        by_gyro = after_nT < before_nT and gyro_agrees(problem, lead_s)
        shown = by_gyro or after_nT * policy.far_larger < before_nT
    else:
        baselines = (start, start.with_columns(named.columns(problem)), Baseline.of(moved))
        before, by_name, by_lead = (rms(baseline.residual() * problem.sigma_nT) ** 2 for baseline in baselines)
        by_form = policy.same_family if selection.after.clean else policy.same_coloured
        shown = before - by_lead > (1 - by_form) * (before - by_name)
    if shown:
        yield "the attitude at its time", moved


def is_late(selection: Selection, again: Selection) -> bool:
    """Whether no late-field effect is accepted next to the lead; in a coloured residual, none larger than its form."""
    named, policy = _late_effect(selection), selection.start.problem.policy
    if named is None:
        return True
    share = 0.0 if selection.after.clean else policy.same_form_share
    least_nT = share * _size_nT(named, selection)
    look_alikes = (effect for effect in again.accepted if named.name in (effect.name, *effect.alternatives))
    return not any(_size_nT(effect, again) > least_nT for effect in look_alikes)


def _size_nT(effect: AcceptedEffect, selection: Selection) -> float:
    return effect.evidence.strength * rms(selection.start.problem.sigma_nT)


def _late_effect(selection: Selection) -> AcceptedEffect | None:
    """The accepted effect of a late field whose coefficients may have either sign."""
    candidates = ((effect, effect.evidence.candidate) for effect in selection.accepted)
    late = (effect for effect, each in candidates if each.effect.traits.family == LATE and each.effect.linear)
    return next((effect for effect in late if not effect.evidence.candidate.one_run), None)


def gyro_agrees(problem: LinearProblem, lead_s: float) -> bool:
    """Whether the gyro's rate leads the attitude by about as much as the field does."""
    recording = problem.recording
    if recording.gyro_rad_s is None:
        return False
    match = match_rates(recording.time_s, np.asarray(recording.att_q), recording.gyro_rad_s)
    return match is not None and abs(match.lag_s - lead_s) < problem.policy.half * lead_s


def best_lead_s(problem: LinearProblem, q_at: CubicSpline, first_s: float) -> float:
    """The lead (s) for which a free matrix and offset leave the smallest gap."""
    found = minimize_scalar(
        lambda lead_s: lead_gap_nT(problem, q_at, lead_s),
        bounds=(0.0, FARTHEST * first_s),
        method="bounded",
        options={"xatol": SETTLED_S},
    )
    return float(found.x)


def lead_gap_nT(problem: LinearProblem, q_at: CubicSpline, lead_s: float) -> float:
    """Rms (nT) of the measured field after a free matrix and offset, along the attitude moved by a lead."""
    used = (problem.usable > 0) & known_attitude(problem, lead_s)
    change_enu_nT = np.zeros((1, 3)) if problem.track is None else problem.track.change_enu_nT
    turns = matrix_from_q(attitude_at(q_at, problem.recording.time_s + lead_s))
    field_nT = to_body(turns, problem.state.field_enu_nT + change_enu_nT)
    return gap_beside_iron_nT(problem.recording.mag_nT[used], field_nT[used])


def known_attitude(problem: LinearProblem, lead_s: float) -> NDArray[np.bool_]:
    """Samples (n,) whose attitude was logged before the end of the known part."""
    time_s = problem.recording.time_s
    return np.asarray(time_s + lead_s <= time_s[problem.usable > 0][-1])


def _moved(
    problem: LinearProblem, q_at: CubicSpline, lead_s: float, before_nT: float, after_nT: float
) -> LinearProblem:
    """The problem posed again with the attitude moved by a lead, which lowers the gap; all else unchanged."""
    late = f"{figure(1e3 * lead_s)} ms"
    done = ReferenceCorrection(
        f"The attitude comes {late} later than the field, and was moved to its time.",
        f"Correct the time stamps: with the attitude {late} earlier the gap falls from {figure(before_nT)} to "
        f"{figure(after_nT)} nT, and the rest was found so; the new model states it as navigation.attitude_delay_s. "
        f"An eddy_current of {figure(lead_s)} s alike on all axes, which is ahead of the field and not behind it, "
        "would look the same.",
    )
    recording = replace(problem.recording, att_q=attitude_at(q_at, problem.recording.time_s + lead_s))
    moved = pose_again(problem, recording, problem.state.field_enu_nT, done).without(~known_attitude(problem, lead_s))
    return replace(moved, attitude_delay_s=problem.attitude_delay_s + lead_s)

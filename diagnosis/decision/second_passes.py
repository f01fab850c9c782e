"""Second passes of the selection: the problem is posed in another way, and the new selection kept if better."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar

from diagnosis.decision.choice import AcceptedEffect, Selection
from diagnosis.decision.selection import Progress, choose_windows_again, select
from diagnosis.evidence.baseline import Baseline
from diagnosis.evidence.held_out import withdraw_names
from diagnosis.evidence.reference_checks import gap_beside_iron_nT, pose_without_dip
from diagnosis.problem.blocks import fit
from diagnosis.problem.formulation import pose_again, refit_iron
from diagnosis.problem.known import ReferenceCorrection
from diagnosis.problem.linear import LinearProblem
from diagnosis.problem.motion import attitude_at, attitude_course, pauses_after, sample_noise, unknown_attitude
from scenarios.arrays import Array
from sim.effects.traits import LATE
from sim.rotation import matrix_from_q, to_body
from validation.signals.amplitude import rms
from validation.signals.quaternion_conventions import match_rates
from validation.text import figure

FARTHEST, SETTLED_S = 3.0, 1e-6
"""Largest lead of a late attitude tried, over the first guess, and the accuracy of the search."""
OtherProblems = Callable[[Selection], Iterator[tuple[str, LinearProblem]]]
"""(selection) -> its problem posed in other ways, each with its words."""
IsBetter = Callable[[Selection, Selection], bool]
"""(selection, selection of the problem posed in another way) -> whether the second is kept."""


def select_in_every_way(
    problem: LinearProblem, without: frozenset[str] = frozenset(), say: Progress = lambda what: None
) -> Selection:
    """Run `select_jointly`, and again in each of `WAYS` to pose the problem of the selection kept so far."""
    selection = select_jointly(problem, without, say)
    for other_problems, is_better in WAYS:
        for words, posed in other_problems(selection):
            say(words)
            again = select_jointly(posed, without, say)
            if is_better(selection, again):
                selection = again
                break
    return selection


def select_jointly(
    problem: LinearProblem, without: frozenset[str] = frozenset(), say: Progress = lambda what: None
) -> Selection:
    """Run `select`; without attitude, refit the iron without the effects and select again until the target settles.

    The strength is not linear in iron and effects together: accepted effects change the field's direction, and with it
    the iron. Without attitude only; iron with a larger residual is discarded.
    """
    selection = choose_windows_again(select(problem, without, say))
    for _ in range(problem.policy.joint_passes if problem.mode == "strength" else 0):
        if not selection.accepted:
            break
        anew = refit_iron(problem, _disturbance_nT(selection))
        if _target_change(problem, anew) < problem.policy.joint_settled:
            break
        say("iron and effects jointly")
        problem, again = anew, select(anew, without, say)
        left, left_before = (rms(one.end.residual()) for one in (again, selection))
        if not again.accepted or left > problem.policy.larger * max(1.0, left_before):
            break
        selection = again
    return rejected_if_worse(selection) if problem.mode == "strength" else selection


def rejected_if_worse(selection: Selection) -> Selection:
    """The selection without effects, where the gap was clean and the residual of the accepted effects is not."""
    if not selection.before.clean or selection.after.clean:
        return selection
    judged = withdraw_names(selection.results, ("what it leaves is not clean, as the gap was",))
    return replace(selection, accepted=(), end=selection.start, after=selection.before, results=judged)


def _disturbance_nT(selection: Selection) -> Array:
    """Contribution (n, 3) of the accepted effects to the measurement."""
    problem, c = selection.end.problem, fit(selection.end.sums, selection.end.all_folds).c
    total = np.zeros((len(problem.recording), 3))
    for effect in selection.accepted:
        contribution = effect.evidence.candidate.contribution_nT(problem)
        own, c = np.split(c, [contribution.shape[2]])
        total += contribution @ own @ problem.matrix_behind(effect.evidence.candidate.effect).T
    return total


def _target_change(before: LinearProblem, after: LinearProblem) -> float:
    """Rms by which the target changes beyond the base, in units of the noise."""
    moved = (after.target - before.target) * before.usable[:, None]
    both = np.concatenate([before.base, after.base], axis=-1)
    flat = both.reshape(-1, both.shape[-1])
    rows = moved.reshape(len(flat), -1)  # outputs with coefficients in common are further rows
    return rms(rows - flat @ np.linalg.lstsq(flat, rows, rcond=1e-10)[0])


def without_dip(selection: Selection) -> Iterator[tuple[str, LinearProblem]]:
    """Strength alone where strength with dip leaves a residual: errors of roll and pitch turn the field."""
    problem = selection.end.problem
    if problem.level is not None and not selection.after.clean:
        dip = selection.end.residual()[problem.usable > 0, 1]
        dip_nT = float(np.sqrt(max((dip**2).mean() - 1, 0.0)) * problem.sigma_nT[1])
        yield "the strength alone", pose_without_dip(problem, dip_nT)


def _finds_more(selection: Selection, again: Selection) -> bool:
    """Whether a selection finds effects and leaves a clean residual, or either where the first finds nothing."""
    clean = again.after.clean
    return bool(again.accepted and clean) if selection.accepted else bool(again.accepted) or clean


def without_stated_effect(selection: Selection) -> Iterator[tuple[str, LinearProblem]]:
    """The model without one of its effects, where a residual is left: a lag, a place or a threshold may be wrong.

    A second effect of the same name mends a gain alone, since gains add. Iron, noise and the converter stay.
    """
    problem = selection.end.problem
    for effect in problem.effects if problem.turns and not selection.after.clean else ():
        settled = effect.traits.absorbed or effect.traits.converter or effect.stochastic
        if settled or not effect.linear or not set(effect.names()) - set(effect.linear):
            continue
        rest = tuple(other for other in problem.effects if other is not effect)
        done = ReferenceCorrection(
            f"The model's {effect.name} does not fit with any gain; it was left out and looked for anew.",
            f"Take the {effect.name} of the new model instead of the given one: not its size alone is wrong.",
        )
        left_out, corrections = (*problem.left_out, effect), (*problem.corrections, done)
        posed = pose_again(problem, effects=rest, left_out=left_out, corrections=corrections)
        yield f"the model without its {effect.name}", posed


def _finds_it_anew(selection: Selection, again: Selection) -> bool:
    """Whether the effect left out of the model is accepted anew, and the residual then clean."""
    return again.after.clean and again.start.problem.left_out[-1].name in again.names


def in_noise_left(selection: Selection) -> Iterator[tuple[str, LinearProblem]]:
    """The noise that accepted effects leave, where smaller than taken before: a switched current counts as noise.

    Vector mode only: by strength alone the noise is estimated anew with the iron.
    """
    problem = selection.end.problem
    if problem.mode == "vector" and selection.accepted:
        used = problem.usable > 0
        residual_nT = selection.end.residual()[used] * problem.sigma_nT
        left_nT = sample_noise(residual_nT, pauses_after(problem.state.time_s[used], problem.policy))
        if (left_nT * problem.policy.larger < problem.sigma_nT).any() and np.isfinite(left_nT).all():
            target = problem.target * (problem.sigma_nT / left_nT)
            yield "the noise anew", replace(problem, target=target, sigma_nT=left_nT)


def attitude_in_time(selection: Selection) -> Iterator[tuple[str, LinearProblem]]:
    """The attitude moved in time, where a common lead explains as much as a late-field effect, or nearly all by itself.

    The field leads an attitude that is logged late. A late measurement is one of the effects; a measurement ahead of
    the attitude is none, but the effects with free coefficients on the field's rate fit it. A varying delay leaves too
    much for any effect to be accepted: the lead must then lower the gap as another reading of the reference would, or
    agree with the gyro, which is independent of the field.
    """
    start, problem, policy = selection.start, selection.start.problem, selection.start.problem.policy
    if not problem.turns:
        return
    rate = problem.whitened(problem.state.field_rate_nT_s[:, :, None])
    first_s = float(fit(start.sums_with(rate), start.all_folds).c[-1])  # common to all axes: the lead, if small
    if first_s <= policy.fair_share * problem.state.interval_s:
        return
    q_at = attitude_course(problem.recording.time_s, np.asarray(problem.recording.att_q))
    lead_s = best_lead_s(problem, q_at, first_s)
    before_nT, after_nT = (lead_gap_nT(problem, q_at, each_s) for each_s in (0.0, lead_s))
    moved = _moved(problem, q_at, lead_s, f"from {figure(before_nT)} to {figure(after_nT)} nT")
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
    if (named := _late_effect(selection)) is None:
        return True
    share = 0.0 if selection.after.clean else selection.start.problem.policy.same_form_share
    noise_nT, noise_again_nT = (rms(one.start.problem.sigma_nT) for one in (selection, again))
    look_alikes = (effect for effect in again.accepted if named.name in (effect.name, *effect.alternatives))
    largest = max((effect.evidence.strength for effect in look_alikes), default=0.0)
    return largest * noise_again_nT <= share * named.evidence.strength * noise_nT


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
    gap_nT, bounds = partial(lead_gap_nT, problem, q_at), (0.0, FARTHEST * first_s)
    return float(minimize_scalar(gap_nT, bounds=bounds, method="bounded", options={"xatol": SETTLED_S}).x)


def lead_gap_nT(problem: LinearProblem, q_at: CubicSpline, lead_s: float) -> float:
    """Rms (nT) of the measured field after a free matrix and offset, along the attitude moved by a lead."""
    used = (problem.usable > 0) & ~without_attitude(problem, lead_s)
    change_enu_nT = np.zeros((1, 3)) if problem.track is None else problem.track.change_enu_nT
    turns = matrix_from_q(attitude_at(q_at, problem.recording.time_s + lead_s))
    field_nT = to_body(turns, problem.state.field_enu_nT + change_enu_nT)
    return gap_beside_iron_nT(problem.recording.mag_nT[used], field_nT[used])


def without_attitude(problem: LinearProblem, lead_s: float) -> NDArray[np.bool_]:
    """Samples (n,) whose attitude was logged after the known part, or in a pause."""
    time_s, last = problem.recording.time_s, int(np.flatnonzero(problem.usable)[-1])
    return unknown_attitude(time_s[: last + 1], time_s + lead_s, problem.policy)


def _moved(problem: LinearProblem, q_at: CubicSpline, lead_s: float, falls: str) -> LinearProblem:
    """The problem posed again with the attitude moved by a lead; all else unchanged."""
    late = f"{figure(1e3 * lead_s)} ms"
    done = ReferenceCorrection(
        f"The attitude comes {late} later than the field, and was moved to its time.",
        f"Correct the time stamps: with the attitude {late} earlier the gap falls {falls}, and the rest was found so; "
        "the new model states it as navigation.attitude_delay_s. "
        f"An eddy_current of {figure(lead_s)} s alike on all axes, which is ahead of the field and not behind it, "
        "would look the same.",
    )
    recording = replace(problem.recording, att_q=attitude_at(q_at, problem.recording.time_s + lead_s))
    delay_s, corrections = problem.attitude_delay_s + lead_s, (*problem.corrections, done)
    moved = pose_again(problem, recording, attitude_delay_s=delay_s, corrections=corrections)
    return moved.without(without_attitude(problem, lead_s))


WAYS: tuple[tuple[OtherProblems, IsBetter], ...] = (
    (without_dip, _finds_more),
    (attitude_in_time, is_late),
    (without_stated_effect, _finds_it_anew),
    (in_noise_left, lambda selection, again: bool(again.accepted)),
)
"""In the order in which they are tried."""

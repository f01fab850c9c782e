"""An attitude that comes late: the field is ahead of it, which free coefficients on the field's rate take up."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar

from diagnosis.decision.joint_iron import select_jointly
from diagnosis.decision.selection import Progress, Selection
from diagnosis.decision.white_choice import Accepted
from diagnosis.evidence.baseline import Baseline
from diagnosis.problem.blocks import fit
from diagnosis.problem.formulation import posed_anew
from diagnosis.problem.linear import Instead, LinearProblem
from diagnosis.problem.rates import attitude_at, attitude_course
from scenarios.arrays import Array
from sim.effects.earth import AttitudeMisalignment
from sim.effects.traits import LATE
from sim.rotation import matrix_from_q, to_body
from validation.signals.amplitude import rms
from validation.signals.quaternion_conventions import match_rates

FARTHEST, SETTLED_S = 3.0, 1e-6
"""First guesses of a lead up to which it is looked for, and the accuracy of the search."""


def with_attitude_in_time(selection: Selection, say: Progress = lambda what: None) -> Selection:
    """The selection, or a new one with the attitude moved to its own time where that does as well as a name for it.

    A measurement that is late is one of the effects; one that is ahead of the attitude is none: coefficients of the
    field's rate that any effect of that kin is free to choose. Where one lead for all axes explains nearly as much as
    they do, and none of them is found beside it, the attitude is late. Lateness that varies leaves too much for any of
    them to be found: there a lead must lower the gap as another reading of the reference does, or be the gyro's too,
    which knows nothing of the field.
    """
    if not selection.start.problem.turns:
        return selection
    named = _free_of_kin(selection)
    found = _ahead(selection, named)
    if found is None:
        return selection
    again = select_jointly(found, selection.without, say)
    return selection if named is not None and _is_left(named, selection, again) else again


def _is_left(named: Accepted, selection: Selection, again: Selection) -> bool:
    """Whether a name is found beside the lead too; where something is left beside either, larger than its form."""
    share = 0.0 if selection.after.clean else selection.start.problem.policy.same_form_share
    least_nT = share * _size_nT(named, selection)
    beside = (one for one in again.found if named.name in (one.name, *one.alternatives))
    return any(_size_nT(one, again) > least_nT for one in beside)


def _size_nT(one: Accepted, selection: Selection) -> float:
    return one.evidence.strength * rms(selection.start.problem.sigma_nT)


def _free_of_kin(selection: Selection) -> Accepted | None:
    """What was found of the kin of what is late, with coefficients of either sign."""
    late = [one for one in selection.found if one.evidence.candidate.effect.traits.family == LATE]
    return next((one for one in late if one.evidence.candidate.effect.linear and not one.evidence.candidate.once), None)


def _ahead(selection: Selection, named: Accepted | None) -> LinearProblem | None:
    """The problem with the attitude moved, if a lead explains nearly what a name does, or by itself nearly all."""
    start, policy = selection.start, selection.start.problem.policy
    first_s = _first_lead_s(start)
    if first_s <= policy.least_lead * start.problem.state.interval_s:
        return None
    q_at = _course(start.problem)
    lead_s = _best_lead_s(start.problem, q_at, first_s)
    if named is None:
        before_nT, after_nT = (_gap_nT(start.problem, q_at, one_s) for one_s in (0.0, lead_s))
        shown = after_nT * policy.misread_gap < before_nT or (after_nT < before_nT and _by_gyro(start.problem, lead_s))
        return _moved(start.problem, q_at, lead_s) if shown else None
    moved = _moved(start.problem, q_at, lead_s)
    grounds = (start, start.beside(named.columns(start.problem)), Baseline.of(moved))
    before, by_name, by_lead = map(_power_nT2, grounds)
    by_form = policy.same_kin if selection.after.clean else policy.same_coloured
    return moved if before - by_lead > (1 - by_form) * (before - by_name) else None


def _by_gyro(problem: LinearProblem, lead_s: float) -> bool:
    """Whether the gyro's rate is ahead of the attitude's by about as much as the field is."""
    recording = problem.recording
    if recording.gyro_rad_s is None:
        return False
    match = match_rates(recording.time_s, np.asarray(recording.att_q), recording.gyro_rad_s)
    return match is not None and abs(match.lag_s - lead_s) < problem.policy.same_lateness * lead_s


def _first_lead_s(start: Baseline) -> float:
    """The coefficient of the field's rate, alike on all axes: for a small lead that lead itself."""
    rate = start.problem.whitened(start.problem.state.field_rate_nT_s[:, :, None], AttitudeMisalignment)
    return float(fit(start.joined(rate), start.everything).c[-1])


def _course(problem: LinearProblem) -> CubicSpline:
    """The logged attitude."""
    return attitude_course(problem.recording.time_s, np.asarray(problem.recording.att_q))


def _best_lead_s(problem: LinearProblem, q_at: CubicSpline, first_s: float) -> float:
    """The lead (s) with which a free matrix and offset leave least."""
    found = minimize_scalar(
        lambda lead_s: _gap_nT(problem, q_at, lead_s),
        bounds=(0.0, FARTHEST * first_s),
        method="bounded",
        options={"xatol": SETTLED_S},
    )
    return float(found.x)


def _gap_nT(problem: LinearProblem, q_at: CubicSpline, lead_s: float) -> float:
    """Rms (nT) that a free matrix and offset leave of the measured field along the moved attitude."""
    used = (problem.usable > 0) & _known(problem, lead_s)
    change_enu_nT = np.zeros((1, 3)) if problem.track is None else problem.track.change_enu_nT
    turns = matrix_from_q(attitude_at(q_at, problem.recording.time_s + lead_s))
    field_nT = to_body(turns, problem.state.field_enu_nT + change_enu_nT)
    base = np.column_stack([field_nT / 1e4, np.ones(len(field_nT))])[used]
    mag_nT = problem.recording.mag_nT[used]
    return rms(mag_nT - base @ np.linalg.lstsq(base.T @ base, base.T @ mag_nT, rcond=1e-13)[0])


def _known(problem: LinearProblem, lead_s: float) -> NDArray[np.bool_]:
    """Samples (n,) whose attitude was logged before the end of what is known."""
    time_s = problem.recording.time_s
    return np.asarray(time_s + lead_s <= time_s[problem.usable > 0][-1])


def _moved(problem: LinearProblem, q_at: CubicSpline, lead_s: float) -> LinearProblem:
    """The problem posed anew with the attitude moved, all else as it was."""
    recording = replace(problem.recording, att_q=attitude_at(q_at, problem.recording.time_s + lead_s))
    field_enu_nT = problem.state.field_enu_nT
    done = _told(lead_s, _gap_nT(problem, q_at, 0.0), _gap_nT(problem, q_at, lead_s), field_enu_nT)
    return posed_anew(problem, recording, field_enu_nT, done).without(~_known(problem, lead_s))


def _told(lead_s: float, before_nT: float, after_nT: float, field_enu_nT: Array) -> Instead:
    late = f"{1e3 * lead_s:.3g} ms"
    figures = (
        f"Correct the time stamps: with the attitude {late} earlier the gap falls from {before_nT:.3g} to "
        f"{after_nT:.3g} nT, and the rest was found so. An eddy_current of {lead_s:.3g} s alike on all axes, which is "
        "ahead of the field and not behind it, would look the same."
    )
    return Instead(f"The attitude comes {late} later than the field, and was moved to its time.", figures, field_enu_nT)


def _power_nT2(ground: Baseline) -> float:
    """Mean square (nT^2) of what a ground leaves."""
    return rms(ground.residual() * ground.problem.sigma_nT) ** 2

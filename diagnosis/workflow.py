"""The diagnosis of a recording against a model: verdict, new model, and the gap before and after."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace

import numpy as np

from calib.numerics.threads import one_thread
from diagnosis.decision.advice import advice_for
from diagnosis.decision.choice import Selection
from diagnosis.decision.conclusion import absorbed_effects, conclude
from diagnosis.decision.second_passes import select_in_every_way
from diagnosis.decision.sentence import sentence_for
from diagnosis.decision.verdict_rules import judge
from diagnosis.evidence.active_parts import split_by_power
from diagnosis.evidence.direct import DirectFinding, direct_evidence, find_start_samples, held_rows
from diagnosis.evidence.held_out import withdraw_names
from diagnosis.evidence.reference_checks import correct_reference
from diagnosis.policy import STANDARD, Policy
from diagnosis.problem.formulation import pose_model
from diagnosis.problem.linear import LinearProblem
from diagnosis.repair.named_effects import better_channels, explain, follow_channels
from diagnosis.repair.new_model import patch_model, resimulated_rms_nT
from diagnosis.result import OF_VALUES, Diagnosis, EvidenceKind, Explanation
from diagnosis.verdict import Verdict
from recordings import Recording
from scenarios.arrays import Array
from sim.effects import BY_NAME
from sim.scenario import Model

Progress = Callable[[str], object]


@dataclass(frozen=True)
class Examination:
    """A recording compared with a model, and what was selected; whole : the problem as first posed, of all samples."""

    whole: LinearProblem
    model: Model
    direct: tuple[DirectFinding, ...]
    selection: Selection

    @property
    def problem(self) -> LinearProblem:
        """The problem at the end of the selection."""
        return self.selection.end.problem


@one_thread()
def diagnose(
    recording: Recording,
    model: Model,
    field_enu_nT: Array | None = None,
    strength_nT: float | None = None,
    *,
    fitted_base: bool = False,
    without: frozenset[str] = frozenset(),
    policy: Policy = STANDARD,
    say: Progress = lambda step: None,
) -> Diagnosis:
    """Diagnose where a recording and a model disagree, and what is missing in the model.

    field_enu_nT, strength_nT : the reference, where the model does not state one. fitted_base : the model's iron is
    unknown, hence a difference of the base is no finding. without : effects left out of the library. policy : the
    limits of evidence.

    Raises InputError as `diagnosis.problem.formulation.pose` does, and for an invalid effect table of the model.
    """
    say("direct evidence")
    problem = pose_model(recording, model, field_enu_nT, strength_nT, iron_known=not fitted_base, policy=policy)
    examination = examine(problem, model, without, say)
    say("the simulator with the new model")
    return diagnosis_of(examination)


def examine(
    whole: LinearProblem, model: Model, without: frozenset[str] = frozenset(), say: Progress = lambda step: None
) -> Examination:
    """Examine a posed problem without its invalid samples."""
    measured, direct = measured_rows(whole, without)
    selection = select_in_every_way(correct_reference(measured), without, say)
    return Examination(whole, model, direct, conclude(selection))


def measured_rows(
    whole: LinearProblem, without: frozenset[str] = frozenset()
) -> tuple[LinearProblem, tuple[DirectFinding, ...]]:
    """The problem without invalid samples and samples of unknown past, and the direct evidence."""
    direct = tuple(direct_evidence(whole, without))
    left_out = [held_rows(whole), find_start_samples(whole), *(finding.samples for finding in direct)]
    wrong_values = any(finding.effect.traits.sign == "outliers" for finding in direct)
    measured = replace(whole.without(np.logical_or.reduce(left_out)), wrong_values=wrong_values)
    return measured, tuple(finding for finding in direct if not finding.stated)


def diagnosis_of(examination: Examination) -> Diagnosis:
    """The diagnosis of an examination, with sentences and the new model."""
    problem, selection = examination.problem, examination.selection
    found = explain(selection, examination.direct)
    verdict, (judged,) = judge([found])
    if (curves := _curves(selection, found, verdict)) is not None:
        verdict, judged = Verdict.UNKNOWN, replace(curves, doubts=judged.doubts)
    names = {one.name for one in judged.named}
    diagnosis = Diagnosis(
        **{part.name: getattr(judged, part.name) for part in fields(judged)},
        verdict=verdict,
        absorbed=tuple(name for name in absorbed_effects(problem) if name not in names),
        untested=_untested(problem),
        ranking=withdraw_names(selection.results, judged.doubts) if verdict is Verdict.UNKNOWN else selection.results,
        before=selection.before,
        model=patch_model(examination.model, judged.named, problem),
        given=examination.whole.effects,
        parts=split_by_power(problem, selection.start.residual()),
    )
    diagnosis = _resimulated(diagnosis, examination)
    return replace(diagnosis, sentence=sentence_for(diagnosis), advice=advice_for(diagnosis))


def _untested(problem: LinearProblem) -> tuple[str, ...]:
    """Effects whose causes are not recorded, with the causes."""
    lacking = ((name, problem.missing_inputs(effect)) for name, effect in BY_NAME.items())
    return tuple(f"{name} (no {', '.join(channels)})" for name, channels in lacking if channels)


def _curves(selection: Selection, found: Explanation, verdict: Verdict) -> Explanation | None:
    """The channels followed by the gap, where only slow noise is named, or curves explain much more than the names."""
    start, noise_alone = selection.start, selection.noise is not None and not found.of_kind(EvidenceKind.HELD_OUT)
    if verdict is Verdict.UNKNOWN or noise_alone:
        return follow_channels(start, found)
    return better_channels(start, found) if verdict is Verdict.PARTIAL and not found.clean else None


def _resimulated(diagnosis: Diagnosis, examination: Examination) -> Diagnosis:
    """The diagnosis with what its written model leaves; a model that leaves far more than its effects is no answer."""
    problem, policy = diagnosis.problem, diagnosis.problem.policy
    left_nT = resimulated_rms_nT(examination.whole.recording, diagnosis.model, problem)
    told = replace(diagnosis, resimulated_nT=left_nT)
    if left_nT is None or all(cause.kind in OF_VALUES for cause in diagnosis.named):
        return told
    wanders = examination.selection.noise is not None  # its mean over the run is no iron
    told = told if wanders else _with_fitted_iron(told, left_nT, examination)
    most_nT = (policy.tenfold if wanders else policy.clearly_larger) * told.left_nT
    more = told.verdict.explained and (told.resimulated_nT or 0.0) > most_nT
    return replace(told, verdict=Verdict.PARTIAL) if more else told


def _with_fitted_iron(told: Diagnosis, left_nT: float, examination: Examination) -> Diagnosis:
    """The diagnosis with fitted iron in the model where the given iron leaves more than the effects, and this less.

    A curve of a channel, or a cause beside an unknown one, is known next to fitted iron alone.
    """
    problem = told.problem
    if not problem.iron_known or left_nT < problem.policy.larger * told.left_nT:
        return told
    model = patch_model(examination.model, told.named, replace(problem, iron_known=False))
    anew_nT = resimulated_rms_nT(examination.whole.recording, model, problem)
    better = anew_nT is not None and anew_nT * problem.policy.larger < left_nT
    return replace(told, model=model, resimulated_nT=anew_nT, iron_anew=True) if better else told

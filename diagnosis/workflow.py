"""The diagnosis from a recording and a model to a verdict, a new model and the gap before and after."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from calib.numerics.threads import one_thread
from diagnosis.decision.advice import advice_for
from diagnosis.decision.belief import Belief, believed
from diagnosis.decision.dip_or_strength import select_beside_dip
from diagnosis.decision.iron import absorbed_effects
from diagnosis.decision.late_attitude import with_attitude_in_time
from diagnosis.decision.monotone_courses import with_rivals
from diagnosis.decision.sentence import sentence_for
from diagnosis.decision.verdict_rules import VerdictInput, doubts_of, verdict_of
from diagnosis.evidence.active_parts import parts_of
from diagnosis.evidence.candidate_result import taken_back
from diagnosis.evidence.direct import Direct, direct_evidence, held_rows
from diagnosis.evidence.localise import Share, localise
from diagnosis.evidence.reference_checks import settled
from diagnosis.evidence.rising_spectrum import RisingSpectrum
from diagnosis.evidence.start_transients import unknown_past
from diagnosis.library.candidates import missing_channels
from diagnosis.policy import STANDARD, Policy
from diagnosis.problem.formulation import posed
from diagnosis.problem.linear import LinearProblem
from diagnosis.repair.channel_curves import Followed, followed, followed_instead
from diagnosis.repair.named_effects import ModelledGap, names_of
from diagnosis.repair.new_model import patched
from diagnosis.result import Diagnosis, How, Named
from diagnosis.verdict import Verdict
from recordings import Recording
from scenarios.arrays import Array
from sim.effects import BY_NAME
from sim.scenario import Model

Progress = Callable[[str], object]


@dataclass(frozen=True)
class Examined:
    """A recording beside a model, and what is believed of it: all that the words of a diagnosis rest on."""

    model: Model
    problem: LinearProblem
    direct: tuple[Direct, ...]
    belief: Belief


@one_thread()
def diagnose(
    recording: Recording,
    model: Model,
    *,
    field_enu_nT: Array | None = None,
    strength_nT: float | None = None,
    fitted_base: bool = False,
    without: frozenset[str] = frozenset(),
    policy: Policy = STANDARD,
    say: Progress = lambda what: None,
) -> Diagnosis:
    """Where a recording and a model disagree, what is missing, and the model with it.

    field_enu_nT, strength_nT : the reference, where the model does not state it. fitted_base : the model's iron is not
    known, so that a difference of the base is no finding. without : effects left out of the library. policy : what is
    held for evidence.

    Raises InputError as `diagnosis.problem.formulation.pose` does, and for a bad effect table of the model.
    """
    say("direct evidence")
    problem = posed(recording, model, field_enu_nT, strength_nT, iron_known=not fitted_base, policy=policy)
    seen = examined(problem, model, without, say)
    say("the simulator with the new model")
    return told(seen)


def examined(
    whole: LinearProblem, model: Model, without: frozenset[str] = frozenset(), say: Progress = lambda what: None
) -> Examined:
    """What is believed of a problem that was posed with a model, wrong samples left out."""
    measured, direct = measured_rows(whole, without)
    selection = with_attitude_in_time(select_beside_dip(settled(measured), without, say), say)
    return Examined(model, selection.end.problem, direct, believed(selection))


def measured_rows(
    whole: LinearProblem, without: frozenset[str] = frozenset()
) -> tuple[LinearProblem, tuple[Direct, ...]]:
    """The problem without samples that are no measurements, or of an unknown past, and what the values show."""
    direct = tuple(direct_evidence(whole, without))
    left_out = [held_rows(whole), unknown_past(whole), *(one.samples for one in direct)]
    return whole.without(np.logical_or.reduce(left_out)), direct


def told(seen: Examined) -> Diagnosis:
    """The diagnosis of what is believed, in words and with the new model."""
    problem, belief = seen.problem, seen.belief
    named = tuple(with_rivals(problem, one) for one in names_of(problem, belief, seen.direct))
    left = ModelledGap.of(problem, belief)
    where = localise(problem, left.before)
    rise = RisingSpectrum.of(problem, left.before, left.after)
    case = VerdictInput(problem, named, belief.clean, left.gap, where, left.after, rise)
    verdict = verdict_of(case)
    doubts = doubts_of(case, verdict)
    curves = _curves(seen, case, verdict, doubts)
    if curves or doubts or verdict is Verdict.UNKNOWN:  # what explains little is no name
        verdict, left = Verdict.UNKNOWN, curves.left if curves else left.undone()
        named = tuple(one for one in named if one.how is How.DIRECT) + (curves.named if curves else ())
    found = replace(_without_words(seen, named, verdict, doubts, where, left), rise=rise)
    return replace(found, sentence=sentence_for(found), advice=advice_for(found))


def _curves(seen: Examined, case: VerdictInput, verdict: Verdict, doubts: tuple[str, ...]) -> Followed | None:
    """The channels that the gap follows, where nothing but slow noise is named, whose course any slow channel may have.

    Beside names that explain a part of it, where they explain much more.
    """
    selection = seen.belief.selection
    start, noise_alone = selection.start, seen.belief.noise is not None and not case.found
    if doubts or verdict is Verdict.UNKNOWN or noise_alone:
        found = followed(start)
        return followed(start, selection.end) if found is None and selection.found and not doubts else found
    return followed_instead(start, case) if verdict is Verdict.PARTIAL and not case.clean else None


def _without_words(
    seen: Examined,
    named: tuple[Named, ...],
    verdict: Verdict,
    doubts: tuple[str, ...],
    where: tuple[Share, ...],
    left: ModelledGap,
) -> Diagnosis:
    problem, selection, names = seen.problem, seen.belief.selection, {one.name for one in named}
    return Diagnosis(
        verdict=verdict,
        sentence="",
        named=named,
        where=where,
        gap=left.gap,
        absorbed=tuple(name for name in absorbed_effects(problem) if name not in names),
        untested=_untested(problem),
        doubts=doubts,
        ranking=taken_back(selection.judged, doubts) if verdict is Verdict.UNKNOWN else selection.judged,
        before=selection.before,
        after=seen.belief.after,
        model=patched(seen.model, named, problem),
        problem=problem,
        before_nT=left.before * problem.sigma_nT,
        after_nT=left.after * problem.sigma_nT,
        parts=parts_of(problem, selection.start.residual()),
    )


def _untested(problem: LinearProblem) -> tuple[str, ...]:
    """Effects whose causes this recording does not hold, with what is missing."""
    missing = ((name, missing_channels(effect, problem)) for name, effect in BY_NAME.items())
    return tuple(f"{name} (no {', '.join(channels)})" for name, channels in missing if channels)

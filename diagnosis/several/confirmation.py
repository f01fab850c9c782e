"""A second recording: whether the coefficients that a diagnosis found hold there as they are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from diagnosis.decision.advice import advice_for
from diagnosis.decision.sentence import sentence_for
from diagnosis.evidence.candidate_test import ColouredBaseline
from diagnosis.evidence.reference_checks import correct_reference
from diagnosis.library.candidates import Candidate
from diagnosis.problem.formulation import pose_model
from diagnosis.problem.linear import LinearProblem
from diagnosis.problem.strength import refit_iron
from diagnosis.result import FITTED, Diagnosis, NamedEffect, Transfer
from diagnosis.several.pooled_test import PooledCandidate, columns_in
from diagnosis.several.transfer import predicts
from diagnosis.workflow import measured_rows
from recordings import Recording
from scenarios.arrays import Array
from sim.effects.base import Effect
from sim.scenario import Model


def confirmed(
    found: Diagnosis, second: Recording, model: Model, field_enu_nT: Array | None, strength_nT: float | None
) -> Diagnosis:
    """The diagnosis with the evidence of each effect upgraded where the second recording bears it out.

    Each recording has its own iron and a rest with its own colour, and says of the coefficients how large they are. An
    effect is transferred where those of the first, as they are, explain the second, in nats over the inflation of their
    error, and where those of the second agree with them. Where only the strength is known the second's iron is fitted
    with the effects out. An event of one run is none that another could show, nor is an effect that acts in a part.
    """
    whole = pose_model(second, model, field_enu_nT, strength_nT, policy=found.problem.policy)
    effects = [effect for one in found.named if _lasts(one) for effect in one.effects if not effect.traits.absorbed]
    problems = (found.problem, _beside_known(correct_reference(measured_rows(whole)[0]), effects))

    def upgraded(one: NamedEffect) -> NamedEffect:
        if not one.transferable or found.problem.mode != problems[1].mode:
            return one
        others = [effect for effect in effects if effect is not one.effect]
        holds = predicts(_joint(one.effect, others, problems), found.problem.policy)
        return replace(one, transfer=Transfer.TRANSFERRED) if holds else one

    known = replace(found, named=tuple(upgraded(one) for one in found.named), has_second=True)
    return replace(known, sentence=sentence_for(known), advice=advice_for(known))


def _lasts(one: NamedEffect) -> bool:
    """Whether a name has coefficients that hold all through a run."""
    return one.kind in FITTED and one.effect.active_s is None


def _joint(effect: Effect, others: Sequence[Effect], problems: Sequence[LinearProblem]) -> PooledCandidate:
    """An effect asked of both recordings beside the others."""
    coloured_baselines = []
    for problem in problems:
        columns = [each for other in others if (each := columns_in(Candidate.of(other), problem)) is not None]
        coloured_baselines.append(ColouredBaseline.of(problem, columns))
    return PooledCandidate.of(Candidate.of(effect), coloured_baselines, problems, 1)


def _beside_known(problem: LinearProblem, effects: Sequence[Effect]) -> LinearProblem:
    """Without attitude the problem about iron that is fitted with the effects as they are out."""
    if problem.mode != "strength" or not effects:
        return problem
    total_nT = np.zeros((len(problem.recording), 3))
    for effect in effects:
        if columns_in(Candidate.of(effect), problem) is not None:
            kind = type(effect)
            part_nT = effect.contribution(problem.state, problem.input_nT(kind), np.random.default_rng(0), {})
            total_nT += part_nT @ problem.matrix_behind(kind).T
    return refit_iron(problem, total_nT)

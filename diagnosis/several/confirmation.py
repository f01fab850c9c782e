"""Confirmation of a diagnosis by a second recording, with the coefficients of the first."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from diagnosis.decision.advice import advice_for
from diagnosis.decision.sentence import sentence_for
from diagnosis.evidence.reference_checks import correct_reference
from diagnosis.library.candidates import Candidate
from diagnosis.problem.formulation import pose_model, refit_iron
from diagnosis.problem.linear import LinearProblem
from diagnosis.result import FITTED, Diagnosis, NamedEffect, Transfer
from diagnosis.several.pooled_effect import PooledEffect, columns_in
from diagnosis.several.transfer import predicts
from diagnosis.workflow import measured_rows
from recordings import Recording
from scenarios.arrays import Array
from sim.effects.base import Effect
from sim.scenario import Model


def confirmed(
    found: Diagnosis, second: Recording, model: Model, field_enu_nT: Array | None, strength_nT: float | None
) -> Diagnosis:
    """The diagnosis with each effect marked as transferred where the second recording confirms it.

    Each recording has its own iron, its own noise model, and its own estimate of the coefficients. An effect is
    transferred where the coefficients of the first recording explain the second, in nats over the inflation of their
    error, and agree with the estimate of the second. Where only the strength is known, the iron of the second recording
    is fitted with the effects removed. Events of a single run and effects in a window cannot be confirmed.
    """
    whole = pose_model(second, model, field_enu_nT, strength_nT, policy=found.problem.policy)
    effects = [
        effect for one in found.named if _holds_throughout(one) for effect in one.effects if not effect.traits.absorbed
    ]
    problems = (found.problem, _without_known(correct_reference(measured_rows(whole)[0]), effects))

    def confirm(one: NamedEffect) -> NamedEffect:
        if not one.transferable or found.problem.mode != problems[1].mode:
            return one
        others = [Candidate.of(effect) for effect in effects if effect is not one.effect]
        holds = predicts(PooledEffect.beside([Candidate.of(one.effect)], others, problems))
        return replace(one, transfer=Transfer.TRANSFERRED) if holds else one

    known = replace(found, named=tuple(confirm(one) for one in found.named), has_second=True)
    return replace(known, sentence=sentence_for(known), advice=advice_for(known))


def _holds_throughout(one: NamedEffect) -> bool:
    """Whether an effect has coefficients for the whole run."""
    return one.kind in FITTED and one.effect.active_s is None


def _without_known(problem: LinearProblem, effects: Sequence[Effect]) -> LinearProblem:
    """The problem with its iron fitted again after the effects are removed, in strength mode."""
    if problem.mode != "strength" or not effects:
        return problem
    total_nT = np.zeros((len(problem.recording), 3))
    for effect in effects:
        if columns_in(Candidate.of(effect), problem) is not None:
            kind = type(effect)
            part_nT = effect.contribution(problem.state, problem.input_nT(kind), np.random.default_rng(0), {})
            total_nT += part_nT @ problem.matrix_behind(kind).T
    return refit_iron(problem, total_nT)

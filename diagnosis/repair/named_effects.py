"""Named effects with refined parameters, and the gap they explain."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from diagnosis.decision.conclusion import Conclusion
from diagnosis.evidence.direct import DirectFinding
from diagnosis.evidence.white_noise import missing_white_noise
from diagnosis.problem.blocks import fit, inflation
from diagnosis.problem.linear import LinearProblem
from diagnosis.repair.chain import residual_with_iron_refitted
from diagnosis.repair.refinement import refine
from diagnosis.result import EvidenceKind, GapSize, NamedEffect
from scenarios.arrays import Array
from sim.effects.base import Effect


def named_effects(
    problem: LinearProblem, conclusion: Conclusion, direct: Sequence[DirectFinding]
) -> tuple[NamedEffect, ...]:
    """Name all effects: accepted effects and changes of the iron, refined, then direct evidence, then noise."""
    seen = tuple(NamedEffect(finding.effect, (), EvidenceKind.DIRECT, None, 0.0) for finding in direct)
    others = (*_refined_effects(problem, conclusion), *seen)
    return (*others, *named_noise(conclusion, others))


@dataclass(frozen=True)
class ModelledGap:
    """Residuals (n, q) before and after, in units of the noise, and the size of the gap on held-out segments."""

    before: Array
    after: Array
    gap: GapSize

    @classmethod
    def of(cls, problem: LinearProblem, conclusion: Conclusion) -> ModelledGap:
        """The gap explained by a conclusion; parameters and iron are fitted to the training data of the first split.

        Without effects and with a clean residual there is no gap: excess over the noise is chance.
        """
        held = conclusion.selection.end.held_out_samples()
        train, test = ~held & (problem.usable > 0), held & (problem.usable > 0)
        if problem.mode == "vector":
            before, after = _chain_residuals(problem, conclusion, train)
        else:
            selection = conclusion.selection
            before = selection.start.residual()
            after = selection.end.residual() if conclusion.accepted else before
        gap = GapSize.of(before[test], after[test], problem.sigma_nT, problem.policy)
        some = conclusion.accepted or conclusion.iron or not conclusion.after.clean
        return cls(before, after, gap if some else replace(gap, explained=None))

    def without_names(self) -> ModelledGap:
        """The gap without named effects: nothing is explained."""
        return ModelledGap(self.before, self.before, self.gap.without_effects())


def _refined_effects(problem: LinearProblem, conclusion: Conclusion) -> list[NamedEffect]:
    """Accepted effects and changes of the iron, with parameters refined through the simulator's chain."""
    end, noise = conclusion.selection.end, conclusion.coloured_noise
    V = inflation(end.sums, fit(end.sums, end.all_folds), problem.policy) if noise is None else 1.0
    every, refit = np.ones(len(problem.recording), bool), not problem.iron_known
    refined = refine(problem, _fitted_effects(conclusion), every, V, refit_iron=refit, noise=noise)
    accepted = [(effect, EvidenceKind.HELD_OUT) for effect in conclusion.accepted]
    accepted += [(effect, EvidenceKind.IRON) for effect in conclusion.iron]
    named = []
    for effect, spread, (found, how) in zip(refined.effects, refined.spread, accepted, strict=False):
        nats, strength = found.evidence.nats, found.evidence.strength
        cause = NamedEffect(effect, found.alternatives, how, nats, strength, spread, needed=found.needed)
        named.append((cause, found.form_of or found.name))
    return _by_cause(problem, named, refined.effects[len(named) :])


def _by_cause(
    problem: LinearProblem, named: Sequence[tuple[NamedEffect, str]], conventional: Sequence[Effect]
) -> list[NamedEffect]:
    """Merge effects by cause: forms, repeated effects, and iron restating a reference belong to their cause."""
    by_cause: dict[tuple[str, EvidenceKind], NamedEffect] = {}
    for effect, cause_name in named:
        key = (cause_name, effect.kind)
        by_cause[key] = _with_part(by_cause[key], effect) if key in by_cause else effect
    signal_nT = problem.clean_nT
    owners = [
        key for key, cause in by_cause.items() if cause.effect.convention_columns(problem.state, signal_nT).shape[2]
    ]
    if owners and conventional:
        owner = by_cause[owners[0]]
        by_cause[owners[0]] = replace(owner, also=(*owner.also, *conventional))
    return list(by_cause.values())


def _with_part(cause: NamedEffect, part: NamedEffect) -> NamedEffect:
    others = dict.fromkeys((*cause.alternatives, part.name, *part.alternatives))
    return replace(
        cause, alternatives=tuple(name for name in others if name != cause.name), also=(*cause.also, part.effect)
    )


def _fitted_effects(conclusion: Conclusion) -> list[Effect]:
    effects = (*conclusion.accepted, *conclusion.iron, *conclusion.conventional)
    return [effect.evidence.candidate.to_effect(effect.evidence.coefficients) for effect in effects]


def named_noise(conclusion: Conclusion, others: Sequence[NamedEffect]) -> list[NamedEffect]:
    """Slow noise, or white noise in excess of the model's."""
    selection, noise = conclusion.selection, conclusion.noise
    problem = selection.end.problem
    if noise is None:
        noisier = missing_white_noise(problem, selection.end.residual(), [cause.effect for cause in others])
        if noisier is None or noisier.name in selection.without:
            return []
        return [NamedEffect(noisier, (), EvidenceKind.SPECTRUM, None, 0.0)]
    ranking = sorted((result.evidence for result in selection.results), key=lambda evidence: -evidence.gain)
    slow = [evidence.name for evidence in ranking if evidence.nats > problem.policy.apart]
    listed = () if noise.identified else slow[: problem.policy.listed_noises]
    return [NamedEffect(noise.effect, (*noise.alternatives, *listed), EvidenceKind.SPECTRUM, noise.gain, 0.0)]


def _chain_residuals(problem: LinearProblem, conclusion: Conclusion, train: NDArray[np.bool_]) -> tuple[Array, Array]:
    trained = refine(problem, _fitted_effects(conclusion), train, noise=conclusion.coloured_noise).effects
    given = residual_with_iron_refitted(problem, problem.left_out, train)
    return given, residual_with_iron_refitted(problem, trained, train)

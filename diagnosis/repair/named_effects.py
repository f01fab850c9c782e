"""Named effects with refined parameters, and the gap they explain."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from diagnosis.decision.conclusion import Conclusion
from diagnosis.evidence.direct import DirectFinding
from diagnosis.evidence.white_noise import missing_white_noise
from diagnosis.problem.blocks import fit, inflation
from diagnosis.problem.linear import LinearProblem
from diagnosis.repair.chain import chain_residual
from diagnosis.repair.refinement import refine
from diagnosis.result import EvidenceKind, GapSize, NamedEffect
from scenarios.arrays import Array
from sim.effects.base import Effect


def named_effects(
    problem: LinearProblem, conclusion: Conclusion, direct: Sequence[DirectFinding]
) -> tuple[NamedEffect, ...]:
    """Name all effects: accepted effects and changes of the iron, refined, then direct evidence, then noise."""
    effects = _refined_effects(problem, conclusion)
    return (*effects, *named_values(conclusion, direct, effects))


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
        selection, used = conclusion.selection, problem.usable > 0
        held = selection.end.held_out_samples()
        train, test = ~held & used, held & used
        if problem.mode == "vector":
            trained = refine(problem, _fitted_effects(conclusion), train, noise=conclusion.coloured_noise).effects
            before, after = (chain_residual(problem, effects, train) for effects in (problem.left_out, trained))
        else:
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
    found = [(effect, EvidenceKind.HELD_OUT) for effect in conclusion.accepted]
    found += [(effect, EvidenceKind.IRON) for effect in conclusion.iron]
    named = []
    for effect, spread, (one, kind) in zip(refined.effects, refined.spread, found, strict=False):
        evidence = one.evidence
        cause = NamedEffect(effect, one.alternatives, kind, evidence.nats, evidence.strength, spread, needed=one.needed)
        named.append((cause, one.form_of or one.name))
    return _by_cause(problem, named, refined.effects[len(named) :])


def _by_cause(
    problem: LinearProblem, named: Sequence[tuple[NamedEffect, str]], conventional: Sequence[Effect]
) -> list[NamedEffect]:
    """Merge effects by cause: forms, repeated effects, and iron restating a reference belong to their cause."""
    by_cause: dict[tuple[str, EvidenceKind], NamedEffect] = {}
    for effect, cause_name in named:
        key = (cause_name, effect.kind)
        by_cause[key] = _with_part(by_cause[key], effect) if key in by_cause else effect
    for key, cause in by_cause.items() if conventional else ():
        if cause.effect.convention_columns(problem.state, problem.clean_nT).shape[2]:
            by_cause[key] = replace(cause, also=(*cause.also, *conventional))
            break
    return list(by_cause.values())


def _with_part(cause: NamedEffect, part: NamedEffect) -> NamedEffect:
    others = dict.fromkeys((*cause.alternatives, part.name, *part.alternatives))
    return replace(
        cause, alternatives=tuple(name for name in others if name != cause.name), also=(*cause.also, part.effect)
    )


def _fitted_effects(conclusion: Conclusion) -> list[Effect]:
    effects = (*conclusion.accepted, *conclusion.iron, *conclusion.conventional)
    return [effect.evidence.candidate.to_effect(effect.evidence.coefficients) for effect in effects]


def named_values(
    conclusion: Conclusion, direct: Sequence[DirectFinding], effects: Sequence[NamedEffect]
) -> list[NamedEffect]:
    """Direct evidence, then slow noise, or white noise in excess of the model's and of the named effects'."""
    seen = [NamedEffect(finding.effect, (), EvidenceKind.DIRECT, None, 0.0) for finding in direct]
    return [*seen, *_named_noise(conclusion, (*effects, *seen))]


def _named_noise(conclusion: Conclusion, others: Sequence[NamedEffect]) -> list[NamedEffect]:
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

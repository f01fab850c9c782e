"""Named effects with refined parameters, and the gap they explain."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from diagnosis.decision.choice import AcceptedEffect
from diagnosis.decision.conclusion import Conclusion
from diagnosis.decision.monotone_courses import with_rival_channels
from diagnosis.evidence.direct import DirectFinding
from diagnosis.evidence.residual_tests import missing_white_noise
from diagnosis.problem.blocks import fit, inflation
from diagnosis.problem.linear import LinearProblem
from diagnosis.repair.refinement import chain_residual, refine
from diagnosis.result import EvidenceKind, Explanation, NamedEffect
from scenarios.arrays import Array
from sim.effects.base import Effect


def explain(problem: LinearProblem, conclusion: Conclusion, direct: Sequence[DirectFinding]) -> Explanation:
    """Name all effects: accepted effects and changes of the iron, refined, then direct evidence, then noise.

    For the gap, parameters and iron are fitted to the training data of the first split. Without effects and with a
    clean residual there is no gap: excess over the noise is chance.
    """
    effects = _refined_effects(problem, conclusion)
    named = [*effects, *named_values(conclusion, direct, effects)]
    selection = conclusion.selection
    held_out = selection.end.held_out_samples()
    if problem.mode == "vector":
        train = ~held_out & (problem.usable > 0)
        trained, _ = refine(problem, _fitted_effects(conclusion), train, noise=conclusion.coloured_noise)
        before, after = (chain_residual(problem, effects, train) for effects in (problem.left_out, trained))
    else:
        before = selection.start.residual()
        after = selection.end.residual() if conclusion.accepted else before
    found = Explanation.by(problem, named, (before, after), held_out, conclusion.after, clean=conclusion.clean)
    some = conclusion.accepted or conclusion.iron or not conclusion.after.clean
    return found if some else replace(found, gap=replace(found.gap, explained=None))


def _fitted_effects(conclusion: Conclusion) -> list[Effect]:
    effects = (*conclusion.accepted, *conclusion.iron, *conclusion.conventional)
    return [effect.evidence.candidate.to_effect(effect.evidence.coefficients) for effect in effects]


def _refined_effects(problem: LinearProblem, conclusion: Conclusion) -> list[NamedEffect]:
    """Accepted effects and changes of the iron, refined through the simulator's chain, with their rival channels.

    Forms, repeated effects, and iron restating a reference belong to their cause.
    """
    end, noise = conclusion.selection.end, conclusion.coloured_noise
    V = inflation(end.sums, fit(end.sums, end.all_folds), problem.policy) if noise is None else 1.0
    every, refit = np.ones(len(problem.recording), bool), not problem.iron_known
    effects, spread = refine(problem, _fitted_effects(conclusion), every, V, refit_iron=refit, noise=noise)
    accepted = [(effect, EvidenceKind.HELD_OUT) for effect in conclusion.accepted]
    accepted += [(effect, EvidenceKind.IRON) for effect in conclusion.iron]
    causes, conventional = _by_cause(accepted, effects, spread), effects[len(accepted) :]
    for key, cause in causes.items() if conventional else ():
        if cause.effect.convention_columns(problem.state, problem.clean_nT).shape[2]:
            causes[key] = replace(cause, also=(*cause.also, *conventional))
            break
    return [with_rival_channels(problem, cause) for cause in causes.values()]


def _by_cause(
    accepted: Sequence[tuple[AcceptedEffect, EvidenceKind]],
    effects: Sequence[Effect],
    spread: Sequence[dict[str, Array]],
) -> dict[tuple[str, EvidenceKind], NamedEffect]:
    """Accepted effects with their fits by name and kind of the cause."""
    causes: dict[tuple[str, EvidenceKind], NamedEffect] = {}
    for (one, kind), effect, std in zip(accepted, effects, spread, strict=False):
        key, evidence = (one.form_of or one.name, kind), one.evidence
        if (cause := causes.get(key)) is None:
            nats, strength = evidence.nats, evidence.strength
            causes[key] = NamedEffect(effect, one.alternatives, kind, nats, strength, std, needed=one.needed)
        else:
            others = dict.fromkeys((*cause.alternatives, effect.name, *one.alternatives))
            alternatives = tuple(name for name in others if name != cause.name)
            causes[key] = replace(cause, alternatives=alternatives, also=(*cause.also, effect))
    return causes


def named_values(
    conclusion: Conclusion, direct: Sequence[DirectFinding], effects: Sequence[NamedEffect]
) -> list[NamedEffect]:
    """Direct evidence, then slow noise, or white noise in excess of the model's and of the named effects'."""
    selection, noise = conclusion.selection, conclusion.noise
    problem = selection.end.problem
    seen = [NamedEffect(finding.effect, (), EvidenceKind.DIRECT, None, 0.0) for finding in direct]
    if noise is not None:
        ranking = sorted((result.evidence for result in selection.results), key=lambda evidence: -evidence.gain)
        slow = [evidence.name for evidence in ranking if evidence.nats > problem.policy.apart]
        listed = () if noise.identified else slow[: problem.policy.listed_noises]
        alternatives = (*noise.alternatives, *listed)
        return [*seen, NamedEffect(noise.effect, alternatives, EvidenceKind.SPECTRUM, noise.gain, 0.0)]
    known = [cause.effect for cause in (*effects, *seen)]
    noisier = missing_white_noise(problem, selection.end.residual(), known)
    if noisier is None or noisier.name in selection.without:
        return seen
    return [*seen, NamedEffect(noisier, (), EvidenceKind.SPECTRUM, None, 0.0)]

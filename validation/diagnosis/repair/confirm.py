"""The second recording: coefficients frozen, base refitted; a finding that holds there is transferred."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from sim.dataset import Recording
from sim.effects.base import Effect
from sim.scenario import Model
from sim.state import Array
from validation.diagnosis.decision.wording import advice_for
from validation.diagnosis.problem.blocks import Cut, Fit, block_sums, colour, sums
from validation.diagnosis.problem.linear import LinearProblem
from validation.diagnosis.problem.pose import posed
from validation.diagnosis.repair.chain import left_with_iron_refitted, predict
from validation.diagnosis.result import Diagnosis, How, Named, Reach

FITTED = (How.HELD_OUT, How.CURVE)
"""Names whose coefficients another recording can bear out."""


def confirmed(
    found: Diagnosis, second: Recording, model: Model, field_enu_nT: Array | None, strength_nT: float | None
) -> Diagnosis:
    """The diagnosis with the evidence of each effect upgraded where the second recording bears it out.

    Gain of each effect with its coefficients as they are, beside the others, in nats over the inflation by colour; the
    base is fitted to the second recording. In vector mode only: without attitude the evidence stays "single-run".
    An event of one run is none that another could show, nor is an effect that acts in a part of it.
    """
    problem = posed(second, model, field_enu_nT, strength_nT, policy=found.problem.policy)
    if problem.mode != "vector":
        return found
    fixed = [effect for one in found.named if _lasts(one) for effect in one.effects]

    def upgraded(one: Named) -> Named:
        if not _lasts(one) or one.effect.clues.one_run:
            return one
        others = [effect for effect in fixed if not any(effect is own for own in one.effects)]
        borne_out = evidence_there(problem, fixed, others) > problem.policy.apart
        return replace(one, evidence=Reach.TRANSFERRED) if borne_out else one

    known = replace(found, named=tuple(upgraded(one) for one in found.named))
    return replace(known, advice=advice_for(known))


def _lasts(one: Named) -> bool:
    """Whether a name has coefficients that hold all through a run."""
    return one.how in FITTED and one.effect.active_s is None


def evidence_there(problem: LinearProblem, all_effects: list[Effect], others: list[Effect]) -> float:
    """Nats over the inflation by which effects as they are explain a recording better than only some of them."""
    use = np.ones(len(problem.recording), bool)
    full, without = (left_with_iron_refitted(problem, predict(problem, some), use) for some in (all_effects, others))
    return float((without**2).sum() - (full**2).sum()) / 2 / inflation_of(problem, full)


def inflation_of(problem: LinearProblem, left: Array) -> float:
    """Inflation by colour of a residual (n, q) that nothing more is fitted to."""
    cut = Cut.of(len(left), problem.state.interval_s, problem.policy)
    none = np.zeros((len(left), left.shape[1], 0))
    s = sums(cut, np.zeros((len(left), 1)), none, left, np.ones(len(left)))
    nothing = Fit(np.zeros((1, left.shape[1])), np.zeros(0), np.zeros((0, 0)))
    return max(1.0, colour(block_sums(s, nothing), s.count, problem.policy))

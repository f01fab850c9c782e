"""What is believed, as names with refined parameters, and the gap that they leave."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from diagnosis.decision.belief import Belief
from diagnosis.evidence.direct import Direct
from diagnosis.evidence.white_noise import more_noise
from diagnosis.problem.blocks import fit, inflation
from diagnosis.problem.linear import LinearProblem
from diagnosis.repair.chain import left_with_iron_refitted
from diagnosis.repair.refinement import refined
from diagnosis.result import GapSize, How, Named
from scenarios.arrays import Array
from sim.effects.base import Effect


def names_of(problem: LinearProblem, belief: Belief, direct: Sequence[Direct]) -> tuple[Named, ...]:
    """Every name: effects and changes of the iron refined, what the values show, and noise."""
    seen = tuple(Named(one.effect, (), How.DIRECT, None, 0.0) for one in direct)
    others = (*_refined(problem, belief), *seen)
    return (*others, *noise_of(belief, others))


@dataclass(frozen=True)
class ModelledGap:
    """What is left before and after (n, q), in units of the noise, and its size on held-out segments."""

    before: Array
    after: Array
    gap: GapSize

    @classmethod
    def of(cls, problem: LinearProblem, belief: Belief) -> ModelledGap:
        """What believed effects leave; parameters and iron are fitted to what the first split trains on.

        Where nothing is believed and nothing is left there is no gap: what exceeds the noise is chance.
        """
        held = belief.selection.end.held_samples()
        train, test = ~held & (problem.usable > 0), held & (problem.usable > 0)
        if problem.mode == "vector":
            before, after = _left_by_chain(problem, belief, train)
        else:
            selection = belief.selection
            before = selection.start.residual()
            after = selection.end.residual() if belief.found else before
        gap = GapSize.of(before[test], after[test], problem.sigma_nT, problem.policy)
        some = belief.found or belief.iron or not belief.after.clean
        return cls(before, after, gap if some else replace(gap, explained=None))

    def undone(self) -> ModelledGap:
        """The same where the names are taken back: nothing is explained."""
        gap = self.gap
        after = GapSize(
            gap.before_nT, gap.before_sigma, gap.before_nT, gap.before_sigma, None if gap.explained is None else 0.0
        )
        return ModelledGap(self.before, self.before, after)


def _refined(problem: LinearProblem, belief: Belief) -> list[Named]:
    """Effects and changes of the iron with their parameters refined through the simulator's chain."""
    end = belief.selection.end
    V = inflation(end.sums, fit(end.sums, end.everything), problem.policy)
    everything = np.ones(len(problem.recording), bool)
    fine = refined(problem, _made(belief), everything, V, refit_iron=not problem.iron_known)
    rests_on = [(one, How.HELD_OUT) for one in belief.found] + [(one, How.IRON) for one in belief.iron]
    named = [
        Named(effect, one.alternatives, how, one.evidence.nats, one.evidence.strength, spread, needed=one.needed)
        for effect, spread, (one, how) in zip(fine.effects, fine.spread, rests_on, strict=False)
    ]
    causes = [one.form_of or one.name for one, _ in rests_on]
    return _as_causes(problem, list(zip(named, causes, strict=True)), fine.effects[len(named) :])


def _as_causes(problem: LinearProblem, named: Sequence[tuple[Named, str]], counted: Sequence[Effect]) -> list[Named]:
    """One name a cause: its form, what is found again, and the iron that its convention brings belong to it."""
    out: dict[tuple[str, How], Named] = {}
    for one, cause in named:
        key = (cause, one.how)
        out[key] = _joined(out[key], one) if key in out else one
    owners = [
        key for key, one in out.items() if one.effect.convention_columns(problem.state, problem.clean_nT).shape[2]
    ]
    if owners and counted:
        out[owners[0]] = replace(out[owners[0]], also=(*out[owners[0]].also, *counted))
    return list(out.values())


def _joined(first: Named, again: Named) -> Named:
    others = dict.fromkeys((*first.alternatives, again.name, *again.alternatives))
    return replace(
        first, alternatives=tuple(name for name in others if name != first.name), also=(*first.also, again.effect)
    )


def _made(belief: Belief) -> list[Effect]:
    everything = (*belief.found, *belief.iron, *belief.counted)
    return [one.evidence.candidate.made(one.evidence.coefficients) for one in everything]


def noise_of(belief: Belief, others: Sequence[Named]) -> list[Named]:
    """Slow noise, or more white noise than the model has."""
    selection, noise = belief.selection, belief.noise
    problem = selection.end.problem
    if noise is None:
        noisier = more_noise(problem, selection.end.residual(), [one.effect for one in others])
        if noisier is None or noisier.name in selection.without:
            return []
        return [Named(noisier, (), How.SPECTRUM, None, 0.0)]
    by_white = sorted((one.evidence for one in selection.judged), key=lambda one: -one.gain)
    slow = [one.name for one in by_white if one.nats > problem.policy.apart]
    listed = () if noise.identified else slow[: problem.policy.listed_noises]
    return [Named(noise.effect, (*noise.alternatives, *listed), How.SPECTRUM, noise.gain, 0.0)]


def _left_by_chain(problem: LinearProblem, belief: Belief, train: NDArray[np.bool_]) -> tuple[Array, Array]:
    trained = refined(problem, _made(belief), train).effects
    return left_with_iron_refitted(problem, (), train), left_with_iron_refitted(problem, trained, train)

"""Effects that the model states and that are named: one effect with other parameters, in place of two."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from diagnosis.problem.linear import LinearProblem
from diagnosis.repair.chain import residual_with_model_iron
from diagnosis.repair.refinement import refine
from scenarios.arrays import Array
from scenarios.errors import InputError
from sim.effects.base import Effect


def as_one(chain: Sequence[Effect], problem: LinearProblem) -> list[Effect]:
    """Join two effects of one name in a chain, if one effect with other parameters leaves no more of the gap.

    The model's lag and the lag named beside it are a single lag. Vector mode only.
    """
    joined = list(chain)
    if problem.mode == "vector" and not (problem.still or problem.relative):
        for own, change in _pairs(joined):
            joined = _joined(joined, own, change, problem)
    return joined


def _pairs(chain: Sequence[Effect]) -> list[tuple[Effect, Effect]]:
    """Effects of one name of which the chain has two, both linear in a size and acting throughout."""
    able = [effect for effect in chain if effect.linear and effect.active_s is None]
    count = Counter(effect.name for effect in able)
    return [
        (first, second)
        for first, second in itertools.combinations(able, 2)
        if first.name == second.name and count[first.name] == 2
    ]


def _joined(chain: list[Effect], own: Effect, change: Effect, problem: LinearProblem) -> list[Effect]:
    others = [effect for effect in chain if effect is not own and effect is not change]
    about = replace(problem, effects=tuple(others), iron_known=True)
    nonlinear = {name: getattr(own, name) for name in own.names() if name not in own.linear}
    try:
        sum_of_both = own.combine(own.coefficients() + change.coefficients(), **nonlinear)
    except InputError:  # beyond the effect's bounds
        return chain
    (one,) = refine(about, [sum_of_both], problem.usable > 0, refit_iron=False).effects
    with_two, with_one = (_nats(residual_with_model_iron(about, new)) for new in ((own, change), (one,)))
    kept = (one if effect is own else effect for effect in chain if effect is not change)
    return list(kept) if with_one - with_two < problem.policy.apart else chain


def _nats(residual: Array) -> float:
    """Negative log-likelihood of a residual (n, q) in units of the noise, but for a constant."""
    return float(np.square(residual).sum()) / 2

"""The second recording: coefficients frozen, base refitted; a finding that holds there is transferred."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from scenarios.spec import Model
from sim.dataset import Recording
from sim.state import Array
from validation.diagnosis.evidence.blocks import Cut, Fit, block_sums, colour, sums
from validation.diagnosis.evidence.compare import THRESHOLD
from validation.diagnosis.evidence.problem import posed
from validation.diagnosis.repair.patch import predict, unexplained
from validation.diagnosis.result import Diagnosis, Named

ONE_RUN = ("offset_jump",)
"""Events of one run, which another run cannot show."""


def confirmed(
    found: Diagnosis, second: Recording, model: Model, field_enu_nT: Array | None, strength_nT: float | None
) -> Diagnosis:
    """The diagnosis with the evidence of each effect upgraded where the second recording bears it out.

    Gain of each effect with its coefficients as they are, beside the others, in nats over the inflation by colour; the
    base is fitted to the second recording. In vector mode only: without attitude the evidence stays "single-run".
    """
    problem = posed(second, model, field_enu_nT, strength_nT)
    if problem.mode != "vector":
        return found
    use = np.ones(len(second), bool)
    fixed = [one.effect for one in found.named if one.how == "held-out"]
    full = unexplained(problem, predict(problem, fixed), use)
    V = _colour(full, problem.state.interval_s)

    def upgraded(one: Named) -> Named:
        if one.how != "held-out" or one.name in ONE_RUN:
            return one
        others = [effect for effect in fixed if effect is not one.effect]
        without = unexplained(problem, predict(problem, others), use)
        gain = float((without**2).sum() - (full**2).sum()) / 2 / V
        return replace(one, evidence="transferred") if gain > THRESHOLD else one

    named = tuple(upgraded(one) for one in found.named)
    advice = found.advice
    if any(one.evidence == "transferred" for one in named):
        advice = tuple(line for line in advice if "--confirm" not in line)
    return replace(found, named=named, advice=advice)


def _colour(left: Array, interval_s: float) -> float:
    """Inflation by colour of a residual (n, q) that nothing more is fitted to."""
    cut = Cut.of(len(left), interval_s)
    none = np.zeros((len(left), left.shape[1], 0))
    s = sums(cut, np.zeros((len(left), 1)), none, left, np.ones(len(left)))
    rest = Fit(np.zeros((1, left.shape[1])), np.zeros(0), np.zeros((0, 0)))
    return max(1.0, colour(block_sums(s, rest), s.count))

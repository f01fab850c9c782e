"""Hard and soft iron for a model without iron, fitted together with named effects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from diagnosis.problem.linear import LinearProblem
from diagnosis.problem.strength import strength_problem
from diagnosis.problem.vector import fit_matrix, robust_fit
from diagnosis.problem.vehicle_iron import fitted_iron
from diagnosis.repair.chain import predict
from scenarios.arrays import Array
from scenarios.errors import InputError
from sim.effects.base import Effect
from sim.effects.chain_position import insert_effects

STEPS = 3
"""Number of iron fits: each leaves the effects on the earth's field times the error of the previous iron."""


def fit_iron_with_effects(problem: LinearProblem, effects: Sequence[Effect]) -> LinearProblem:
    """Fit iron with the effects' contributions subtracted, on samples outside their windows if sufficient.

    Unchanged where the model's iron is known.
    """
    acting = [effect.is_active(problem.state.time_s) for effect in effects if effect.active_s is not None]
    use = ~np.logical_or.reduce([problem.usable == 0, *acting])
    vector = problem.mode == "vector"
    as_it_is = not vector and all(effect.stochastic for effect in effects)
    if problem.iron_known or as_it_is or use.sum() < problem.policy.least_samples:
        return problem
    anew = problem
    for _ in range(STEPS if vector else 1):  # no effect on the earth's field is known without attitude
        known = replace(problem, effects=insert_effects(problem.effects, fitted_iron(anew)), iron_known=True)
        added_nT = predict(known, effects) - predict(known, ())
        try:
            anew = _with_iron_fitted(problem, problem.recording.mag_nT - added_nT, use)
        except InputError:
            break
    return anew


def _with_iron_fitted(problem: LinearProblem, mag_nT: Array, use: NDArray[np.bool_]) -> LinearProblem:
    """The problem with iron fitted to the samples `use` (n,) of a measured field (n, 3)."""
    if problem.mode == "vector":
        field_nT, base = problem.state.field_nT, problem.base[use]
        clean_nT = base @ robust_fit(base, (mag_nT - problem.beyond_nT)[use], problem.policy)
        turn = problem.turn if problem.still else fit_matrix(field_nT[use], clean_nT)
        offset_nT = clean_nT.mean(axis=0) - turn @ field_nT[use].mean(axis=0)
        return replace(problem, turn=turn, clean_nT=field_nT @ turn.T + offset_nT + problem.beyond_nT)
    seen = replace(problem.recording, mag_nT=mag_nT).taken(use)
    track = None if problem.track is None else problem.track.at(use)
    level = None if problem.level is None else problem.level.at(use)
    strength_nT = float(np.linalg.norm(problem.state.field_enu_nT))
    return strength_problem(seen, strength_nT, problem.effects, problem.policy, track=track, level=level)

"""White noise beyond the model's."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from diagnosis.problem.linear import LinearProblem, sample_noise
from scenarios.arrays import Array
from sim.effects import of_sign
from sim.effects.base import Effect


def missing_white_noise(problem: LinearProblem, residual: Array, new: Sequence[Effect]) -> Effect | None:
    """The white noise missing in the model, from the residual (n, q) with new effects; None if none is missing.

    Rounding of the values is subtracted, and the sample noise that the new effects carry over from their channels. The
    least ratio that counts is `Policy.larger`.
    """
    given_nT = [effect.first_value for effect in problem.effects if effect.traits.sign == "white"]
    if not given_nT or problem.mode == "strength" or problem.relative:
        return None
    larger = problem.policy.larger
    rounding = sum(one.first_value**2 / 12 for one in (*problem.effects, *new) if one.traits.sign == "lattice")
    expected = np.maximum((np.array(given_nT) ** 2).sum(axis=0) + rounding + _brought(problem, new), 1e-12)
    seen = (sample_noise(residual) * problem.sigma_nT) ** 2
    if (seen <= larger**2 * expected).all():
        return None
    if problem.attitude_std_rad > 0 and problem.turns:  # a walk of the attitude looks white from sample to sample
        w = problem.field_projection
        along = (residual * problem.sigma_nT * w).sum(axis=1) / np.sqrt(w**2 @ expected)
        if sample_noise(along[:, None])[0] <= larger:
            return None
    return of_sign("white", np.sqrt(np.maximum(seen - expected, 0.0)).tolist())


def _brought(problem: LinearProblem, new: Sequence[Effect]) -> Array:
    """Variance (3,) in nT^2 of the white noise carried over by new effects."""
    known = [effect for effect in new if not (effect.stochastic or effect.traits.converter)]
    rng = np.random.default_rng(0)
    parts = [effect.contribution(problem.state, problem.input_nT(type(effect)), rng, {}) for effect in known]
    return sample_noise(np.sum(parts, axis=0)) ** 2 if parts else np.zeros(3)

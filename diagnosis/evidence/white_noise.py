"""More white noise than the model has."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from diagnosis.problem.linear import LinearProblem, sample_noise
from scenarios.arrays import Array
from sim.effects.base import Effect
from sim.effects.electronics import Quantisation
from sim.effects.noise import WhiteNoise


def more_noise(problem: LinearProblem, residual: Array, new: Sequence[Effect]) -> Effect | None:
    """The white noise missing in the model, from what is left (n, q) once the new effects are in too.

    The rounding that the values show is taken off, and what the new effects bring from sample to sample: the noise of
    the channels that drive them. The policy says what ratio counts.
    """
    given = [effect for effect in problem.effects if isinstance(effect, WhiteNoise)]
    if not given or problem.mode == "strength" or problem.relative:
        return None
    rounding = sum(one.step_nT**2 / 12 for one in (*problem.effects, *new) if isinstance(one, Quantisation))
    expected = (np.array([effect.std_nT for effect in given]) ** 2).sum(axis=0) + rounding + _brought(problem, new)
    seen = (sample_noise(residual) * problem.sigma_nT) ** 2
    expected = np.maximum(expected, 1e-12)
    if (seen <= problem.policy.more_noise**2 * expected).all() or _is_the_attitudes(problem, residual, expected):
        return None
    return WhiteNoise(np.sqrt(np.maximum(seen - expected, 0.0)).tolist())


def _brought(problem: LinearProblem, new: Sequence[Effect]) -> Array:
    """Variance (3,) in nT^2 of the white noise of what new effects add."""
    known = [one for one in new if not (one.stochastic or one.traits.converter)]
    parts = [one.contribution(problem.state, problem.met_nT(type(one)), np.random.default_rng(0), {}) for one in known]
    return sample_noise(np.sum(parts, axis=0)) ** 2 if parts else np.zeros(3)


def _is_the_attitudes(problem: LinearProblem, residual: Array, expected: Array) -> bool:
    """Whether the model states errors of the attitude, and along the field, where they add nothing, is no more noise.

    From sample to sample such an error walks, which beside little noise looks white.
    """
    if problem.attitude_std_rad == 0 or not problem.turns:
        return False
    nT, w = residual * problem.sigma_nT, problem.sees_along
    along = (nT * w).sum(axis=1) / np.sqrt(w**2 @ expected)
    return bool(sample_noise(along[:, None])[0] <= problem.policy.more_noise)
